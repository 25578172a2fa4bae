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
  std::optional<double> neighbor_correlation;
};

/// "pass", "warn" or "fail", and why, with what to do.
struct Verdict {
  std::string word;
  std::vector<std::string> reasons;
};

Verdict JudgeCalibration(const CalibrationFigures& figures);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_VERDICT_H
