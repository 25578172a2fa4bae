#ifndef RAYGRID_CALIBRATION_DOUBTFUL_CONDITION_H
#define RAYGRID_CALIBRATION_DOUBTFUL_CONDITION_H

#include <functional>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/camera_stack.h"

namespace raygrid {

/// An image whose stated value of a condition differs by more than chance from
/// the one that is predicted from its features and from the other images.
struct DoubtfulCondition {
  std::string image;
  CameraCondition condition = CameraCondition::kLensPosition;
  double stated = 0;
  double predicted = 0;  ///< within the range
  int num_decimals = 0;  ///< of the prediction

  /// "front_07.png is stated at 9 dioptres, but its features fit 4.2".
  std::string Text() const;
};

/// A condition whose values do not go with how the images differ.
struct UnexplainedCondition {
  CameraCondition condition = CameraCondition::kLensPosition;

  std::string Text() const;
};

/// A condition whose values hardly show in the images.
struct UncertainCondition {
  CameraCondition condition = CameraCondition::kLensPosition;
  double width = 0;      ///< of the range
  double deviation = 0;  ///< of the value that one image's features fit, 1 σ
  double noticed = 0;    ///< the least error of one image's value that shows
  /// How many standard deviations the change over the stated values is away
  /// from none.
  double change_score = 0;

  /// Whether the images show no change that belongs to the values.
  bool IsUnobserved() const;
  std::string Text() const;
};

/// The check of stated values against what the images' features fit. Where
/// values do not explain the images, none is doubtful by itself.
struct ConditionCheck {
  std::vector<DoubtfulCondition> doubtful;
  std::vector<UnexplainedCondition> unexplained;
  std::vector<UncertainCondition> uncertain;
};

/// Checks the stated values of an adjusted stack. given has all features of the
/// images, those that were rejected, too. readjust adjusts the stack once more,
/// to fewer images than before, from where it is.
ConditionCheck CheckConditions(
    const Adjusted& adjusted, const CalibrationProblem& given,
    const std::function<void(Adjusted* fewer)>& readjust, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DOUBTFUL_CONDITION_H
