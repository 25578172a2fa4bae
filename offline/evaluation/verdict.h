#ifndef RAYGRID_EVALUATION_VERDICT_H
#define RAYGRID_EVALUATION_VERDICT_H

#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/camera_file.h"
#include "evaluation/fold_over.h"

namespace raygrid {

/// What a verdict is formed on.
struct CalibrationFigures {
  std::string model;
  bool converged = false, interrupted = false;
  ImageSize image_size;
  Area area;
  int images_used = 0, images_rejected = 0;
  int images_with_too_few_features = 0;  ///< of those rejected
  ErrorFigures training;
  std::optional<ErrorFigures> held_out;
  std::optional<double> neighbor_correlation;  ///< without images apart
  std::vector<std::string> images_apart;  ///< that err far more than others
  int boards_seen = 0, different_views = 0;
  /// Of each time that a board is seen from behind.
  std::vector<std::string> images_from_behind;
  std::optional<double> tilt_rad;  ///< between two boards; of flat ones only
  /// How well the camera is known, the part of its area that is known to
  /// trusted_px.
  std::optional<double> median_deviation_px, trusted_part, trusted_px;
  FoldOver fold_over;
};

/// "pass", "warn" or "fail", and why, with what to do. Reasons of a "pass" are
/// worth knowing, no more.
struct Verdict {
  std::string word;
  std::vector<std::string> reasons;
};

double PartOfImage(const Area& area, const ImageSize& size);

Verdict JudgeCalibration(const CalibrationFigures& figures);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_VERDICT_H
