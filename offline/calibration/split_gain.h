#ifndef RAYGRID_CALIBRATION_SPLIT_GAIN_H
#define RAYGRID_CALIBRATION_SPLIT_GAIN_H

#include <Eigen/Core>
#include <set>
#include <string>
#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Predicts how much better two cameras explain a camera's views than this one
/// does, by a linear step from it: poses eliminated, points fixed. So a split
/// of the images costs two small systems, not two adjustments.
class SplitGain {
 public:
  SplitGain(const AdjustmentResult& joint, double huber_px, int num_threads);

  /// The part of the squared residuals that is left if the images with these
  /// names have a camera of their own, and the others another one. 0, which
  /// excludes nothing, where a camera has too many parameters to be asked.
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
