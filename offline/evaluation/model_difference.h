#ifndef RAYGRID_EVALUATION_MODEL_DIFFERENCE_H
#define RAYGRID_EVALUATION_MODEL_DIFFERENCE_H

#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// The difference of two cameras where both are calibrated.
struct ModelDifference {
  Pose first_from_second;  ///< best alignment of their lines
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector2d> error_px;  ///< first camera's projections
  /// Inverse scene distances of the errors, 1/m; empty for two central cameras.
  std::vector<double> inverse_distances;
  double median_px = 0, rms_px = 0, p99_px = 0, max_px = 0;
};

/// Compares rays at every step_px pixels of the second camera's area. A
/// camera's rotation relative to all poses is a gauge freedom, so the best
/// rotation is removed first: Huber loss of the angles (Wahba's problem,
/// iteratively reweighted).
///
/// Unless both cameras are central, each pixel is evaluated at infinity and at
/// distance_m, and the error is a weighted mean of both; the best translation
/// is removed as well.
ModelDifference CompareModels(const CameraModel& first,
                              const CameraModel& second, double step_px,
                              double distance_m = 1);

/// Compares two central cameras after a given rotation.
ModelDifference CompareRotatedModels(
    const CameraModel& first, const CameraModel& second, double step_px,
    const Eigen::Quaterniond& first_from_second);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_MODEL_DIFFERENCE_H
