#ifndef RAYGRID_CALIBRATION_VALUE_REGRESSION_H
#define RAYGRID_CALIBRATION_VALUE_REGRESSION_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// The value of an operating-point variable that fits one image's features
/// best, independent of its stated value: along the straight line closest to
/// the adjusted model over the stated values, with free poses. A wrong value
/// distorts the model, but hardly the direction in which the camera changes.
struct FittedValue {
  std::string image;
  double stated = 0, fitted = 0, deviation = 0;
};

/// Fits the value of one operating-point variable to the features of each
/// image; omits images that do not determine it.
std::vector<FittedValue> FitValues(const AdjustmentResult& adjusted,
                                   size_t range, int num_threads);

/// Regression of fitted on stated values: a polynomial by least trimmed squares
/// (Rousseeuw, "Least Median of Squares Regression", 1984), which tolerates
/// nearly half of the images as outliers.
struct ValueRegression {
  /// Residuals in units of their standard deviations times `scatter`.
  std::vector<double> scores;
  /// Robust standard deviation of the fitted values around the curve and around
  /// a constant, in units of their predicted standard deviations; and around
  /// the curve in units of the values.
  double scatter = 0, scatter_around_constant = 0, left = 0;
  /// Fraction of random permutations of the stated values that explain the
  /// fitted values as well.
  double p_value = 0;
};

/// Returns no scores if there are too few images.
ValueRegression RegressValues(const std::vector<FittedValue>& values);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_VALUE_REGRESSION_H
