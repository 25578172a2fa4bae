#ifndef RAYGRID_CALIBRATION_OPERATING_POINT_CHECK_H
#define RAYGRID_CALIBRATION_OPERATING_POINT_CHECK_H

#include <functional>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/operating_point_model.h"

namespace raygrid {

/// An image whose stated value is significantly different from the prediction
/// by its features and the other images.
struct SuspectOperatingPoint {
  std::string image;
  OperatingParameter condition = OperatingParameter::kLensPosition;
  double stated = 0;
  double predicted = 0;  ///< within the operating range
  int num_decimals = 0;  ///< decimals of the prediction

  /// Returns "front_07.png is specified as 9 dioptres, but its features
  /// indicate 4.2".
  std::string Text() const;
};

/// A variable whose stated values do not explain the differences of images.
struct UnexplainedOperatingParameter {
  OperatingParameter condition = OperatingParameter::kLensPosition;

  std::string Text() const;
};

/// A variable with hardly any observable effect on the images.
struct UncertainOperatingParameter {
  OperatingParameter condition = OperatingParameter::kLensPosition;
  double width = 0;      ///< width of the range
  double deviation = 0;  ///< 1 σ of the value fitted to one image's features
  double min_detectable_error =
      0;  ///< smallest detectable error of one image's value
  /// Significance of the change over the stated values, in standard deviations.
  double change_score = 0;

  /// Returns whether the images show no change that depends on the values.
  bool IsUnobservable() const;
  std::string Text() const;
};

/// Result of comparing stated values with the images' features. If an
/// operating-point variable is unexplained, no single image is doubtful.
struct OperatingPointCheck {
  std::vector<SuspectOperatingPoint> doubtful;
  std::vector<UnexplainedOperatingParameter> unexplained;
  std::vector<UncertainOperatingParameter> uncertain;
};

/// Checks the stated values of an adjusted operating-point model. `given` has
/// all features, including rejected images. `readjust` optimizes the model
/// again from its current state, with fewer images.
OperatingPointCheck CheckOperatingPoints(
    const AdjustmentResult& adjusted, const CalibrationProblem& given,
    const std::function<void(AdjustmentResult* fewer)>& readjust,
    int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OPERATING_POINT_CHECK_H
