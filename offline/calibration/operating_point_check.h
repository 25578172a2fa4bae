#ifndef RAYGRID_CALIBRATION_OPERATING_POINT_CHECK_H
#define RAYGRID_CALIBRATION_OPERATING_POINT_CHECK_H

#include <functional>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/operating_point_model.h"

namespace raygrid {

/// An image whose stated value of a condition differs by more than chance from
/// the one that is predicted from its features and from the other images.
struct SuspectOperatingPoint {
  std::string image;
  OperatingParameter condition = OperatingParameter::kLensPosition;
  double stated = 0;
  double predicted = 0;  ///< within the range
  int num_decimals = 0;  ///< of the prediction

  /// "front_07.png is stated at 9 dioptres, but its features fit 4.2".
  std::string Text() const;
};

/// A condition whose values do not go with how the images differ.
struct UnexplainedOperatingParameter {
  OperatingParameter condition = OperatingParameter::kLensPosition;

  std::string Text() const;
};

/// A condition whose values hardly show in the images.
struct UncertainOperatingParameter {
  OperatingParameter condition = OperatingParameter::kLensPosition;
  double width = 0;      ///< of the range
  double deviation = 0;  ///< of the value that one image's features fit, 1 σ
  double noticed = 0;    ///< the least error of one image's value that shows
  /// How many standard deviations the change over the stated values is away
  /// from none.
  double change_score = 0;

  /// Whether the images show no change that belongs to the values.
  bool IsUnobservable() const;
  std::string Text() const;
};

/// The check of stated values against what the images' features fit. Where
/// values do not explain the images, none is doubtful by itself.
struct OperatingPointCheck {
  std::vector<SuspectOperatingPoint> doubtful;
  std::vector<UnexplainedOperatingParameter> unexplained;
  std::vector<UncertainOperatingParameter> uncertain;
};

/// Checks the stated values of an adjusted stack. given has all features of the
/// images, those that were rejected, too. readjust adjusts the stack once more,
/// to fewer images than before, from where it is.
OperatingPointCheck CheckOperatingPoints(
    const AdjustmentResult& adjusted, const CalibrationProblem& given,
    const std::function<void(AdjustmentResult* fewer)>& readjust,
    int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OPERATING_POINT_CHECK_H
