#ifndef RAYGRID_CALIBRATION_VALUE_EQUATIONS_H
#define RAYGRID_CALIBRATION_VALUE_EQUATIONS_H

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/operating_point_model.h"

namespace raygrid {

/// A step of Gauss-Newton and its standard deviation; that is infinite where
/// nothing determines the value.
struct ValueStep {
  double step = 0, deviation = 0;

  double Score() const { return std::abs(step) / deviation; }
};

/// The equations of the stated values of an adjusted stack, were these unknown
/// as all else is: one step of Gauss-Newton over the values, with cameras,
/// poses and points eliminated (Schur's complement). Value r of image i is
/// unknown i * num_ranges + r. Of an unknown that is freed alone, the step is
/// the difference between the stated value and what the image's features and
/// all other images predict.
struct ValueEquations {
  std::vector<std::string> images;
  int num_ranges = 0;
  Eigen::VectorXd gradient;
  /// The information on each unknown; and, with the cameras as they are, where
  /// nothing but the image's
  /// own poses is eliminated.
  Eigen::VectorXd information, fixed_camera_information;
  /// Standard deviation of an image's residuals, of all where that is more.
  std::vector<double> noise_px;

  Eigen::Index count() const { return gradient.size(); }
  int ImageOf(Eigen::Index unknown) const {
    return static_cast<int>(unknown) / num_ranges;
  }
  int RangeIndex(Eigen::Index unknown) const {
    return static_cast<int>(unknown) % num_ranges;
  }
  /// The step of an unknown that is freed alone.
  ValueStep ComputeStep(Eigen::Index unknown) const;
};

/// Empty if the equations of the adjustment are singular.
ValueEquations MakeValueEquations(const AdjustmentResult& adjusted,
                                  int num_threads);

/// The value of a range, within limits, that fits the features of one image's
/// views best with the stack as it is, their poses being free. Infinite
/// deviation where they do not determine it.
ValueStep FitValue(AdjustmentState state, const std::vector<View>& views,
                   size_t range, const OperatingRange& limits);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_VALUE_EQUATIONS_H
