#ifndef RAYGRID_EVALUATION_MODEL_DIFFERENCE_H
#define RAYGRID_EVALUATION_MODEL_DIFFERENCE_H

#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// Two cameras compared where both are calibrated.
struct ModelDifference {
  Pose first_from_second;  ///< best motion between their lines
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector2d> error_px;  ///< by the first camera's projection
  /// The inverse distances of what was seen there, 1/m; empty for two central
  /// cameras.
  std::vector<double> inverse_distances;
  double median_px = 0, rms_px = 0, p99_px = 0, max_px = 0;
};

/// Compares rays on a lattice of every step_px pixels of the second camera's
/// area. No calibration can tell its camera's rotation from that of all poses,
/// so the best one is taken out first: Huber's loss on the angles (Wahba's
/// problem, reweighted).
///
/// Unless both cameras are central, each pixel counts twice, by what it sees
/// infinitely far and distance_m away, between which the error is a mean of the
/// two; and the best translation is taken out as well.
ModelDifference CompareModels(const CameraModel& first,
                              const CameraModel& second, double step_px,
                              double distance_m = 1);

/// The difference of two central cameras after a rotation that is known.
ModelDifference CompareTurnedModels(
    const CameraModel& first, const CameraModel& second, double step_px,
    const Eigen::Quaterniond& first_from_second);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_MODEL_DIFFERENCE_H
