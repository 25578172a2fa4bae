#ifndef RAYGRID_EVALUATION_RIGID_TARGET_TEXT_H
#define RAYGRID_EVALUATION_RIGID_TARGET_TEXT_H

#include <string>
#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// The relative pose of two boards that were observed in the same frames.
struct BoardPair {
  int first = 0, second = 0;  ///< board ids
  int num_frames = 0;         ///< number of common frames
  bool fixed = false;  ///< constant relative pose, within the uncertainty
  /// RMS deviation of the second board's centre and rotation, in the frame of
  /// the first, from their mean; and the deviation expected from noise.
  double deviation_m = 0, deviation_rad = 0;
  double expected_m = 0, expected_rad = 0;
};

/// Formats a list: "0, 1 and 2".
std::string FormatList(const std::vector<int>& ids);

/// Describes rigid multi-board targets, and boards that move independently.
std::vector<std::string> DescribeRigidTargets(
    const std::vector<RigidTarget>& rigid_targets,
    const std::vector<BoardPair>& pairs);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_RIGID_TARGET_TEXT_H
