#ifndef RAYGRID_CALIBRATION_SPLIT_GAIN_H
#define RAYGRID_CALIBRATION_SPLIT_GAIN_H

#include <Eigen/Core>
#include <set>
#include <string>
#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Predicts how much better two cameras would explain the views of one camera,
/// by a Gauss-Newton step from it with poses eliminated and points fixed. A
/// split of the images thus costs two small systems, not two adjustments.
class SplitGain {
 public:
  SplitGain(const AdjustmentResult& joint, double huber_px, int num_threads);

  /// Returns the fraction of the squared residuals that remains if the images
  /// with these names have a separate camera. 0, which excludes no split, if
  /// the camera has too many parameters.
  double ComputeRemainingShare(const std::set<std::string>& first) const;

 private:
  // A view's normal equations of the camera.
  struct ViewTerms {
    std::string image;
    Eigen::MatrixXd hessian;
    Eigen::VectorXd gradient;
  };

  std::vector<ViewTerms> views_;
  double squares_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_SPLIT_GAIN_H
