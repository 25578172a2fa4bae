#ifndef RAYGRID_EVALUATION_MODEL_DIFFERENCE_H
#define RAYGRID_EVALUATION_MODEL_DIFFERENCE_H

#include <Eigen/Geometry>
#include <vector>

#include "camera/camera_model.h"

namespace raygrid {

/// Two cameras compared where both are calibrated.
struct ModelDifference {
  Eigen::Quaterniond first_from_second;  ///< best rotation between their rays
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector2d> error_px;  ///< by the first camera's projection
  double median_px = 0, rms_px = 0, p99_px = 0, max_px = 0;
};

/// Compares rays on a lattice of every step_px pixels of the second camera's
/// area. No calibration can tell its camera's rotation from that of all poses,
/// so the best one is taken out first: Huber's loss on the angles (Wahba's
/// problem, reweighted).
ModelDifference CompareModels(const CameraModel& first,
                              const CameraModel& second, double step_px);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_MODEL_DIFFERENCE_H
