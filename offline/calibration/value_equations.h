#ifndef RAYGRID_CALIBRATION_VALUE_EQUATIONS_H
#define RAYGRID_CALIBRATION_VALUE_EQUATIONS_H

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/operating_point_model.h"

namespace raygrid {

/// A Gauss-Newton step of a value and its standard deviation, which is infinite
/// if the features do not determine the value.
struct ValueStep {
  double step = 0, deviation = 0;

  double Score() const { return std::abs(step) / deviation; }
};

/// Equations of the stated values of an adjusted operating-point model, if
/// these were parameters, too: one Gauss-Newton step for the values, with
/// cameras, poses and points eliminated (Schur complement). Value r of image i
/// is unknown i * num_ranges + r. The step of a single freed unknown is the
/// difference between the stated value and the prediction by the image's
/// features and all other images.
struct ValueEquations {
  std::vector<std::string> images;
  int num_ranges = 0;
  Eigen::VectorXd gradient;
  /// Information on each unknown; and with fixed cameras, where only the
  /// image's own poses are eliminated.
  Eigen::VectorXd information, fixed_camera_information;
  /// Standard deviation of each image's residuals; at least that of all images.
  std::vector<double> noise_px;

  Eigen::Index count() const { return gradient.size(); }
  int GetImageIndex(Eigen::Index unknown) const {
    return static_cast<int>(unknown) / num_ranges;
  }
  int RangeIndex(Eigen::Index unknown) const {
    return static_cast<int>(unknown) % num_ranges;
  }
  /// Returns the step of an unknown if it alone is freed.
  ValueStep ComputeStep(Eigen::Index unknown) const;
};

/// Returns empty equations if the adjustment's equations are singular.
ValueEquations MakeValueEquations(const AdjustmentResult& adjusted,
                                  int num_threads);

/// Estimates the value of a range, within limits, that fits the features of one
/// image's views best, with a fixed operating-point model and free poses. The
/// deviation is infinite if the features do not determine it.
ValueStep FitValue(AdjustmentState state, const std::vector<View>& views,
                   size_t range, const OperatingRange& limits);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_VALUE_EQUATIONS_H
