#ifndef RAYGRID_EVALUATION_VERDICT_H
#define RAYGRID_EVALUATION_VERDICT_H

#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/camera_file.h"

namespace raygrid {

/// What a verdict is formed on.
struct CalibrationFigures {
  bool converged = false, interrupted = false;
  ImageSize image_size;
  Area area;
  int images_used = 0, images_rejected = 0;
  ErrorFigures training;
  std::optional<ErrorFigures> held_out;
  std::optional<double> neighbor_correlation;  ///< without images apart
  std::vector<std::string> images_apart;  ///< that err far more than others
  int boards_seen = 0, boards_seen_from_behind = 0, different_views = 0;
  std::optional<double> tilt_rad;  ///< between two boards; of flat ones only
  /// How well the camera is known, the part of its area that is known to
  /// trusted_px.
  std::optional<double> median_deviation_px, trusted_part, trusted_px;
};

/// "pass", "warn" or "fail", and why, with what to do.
struct Verdict {
  std::string word;
  std::vector<std::string> reasons;
};

double PartOfImage(const Area& area, const ImageSize& size);

Verdict JudgeCalibration(const CalibrationFigures& figures);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_VERDICT_H
