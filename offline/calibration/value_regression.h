#ifndef RAYGRID_CALIBRATION_VALUE_REGRESSION_H
#define RAYGRID_CALIBRATION_VALUE_REGRESSION_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// The value of a condition that one image's features fit best, whatever is
/// stated: with the straight line through the adjusted stack that is nearest to
/// it over the stated values, and with the poses free. A value that is wrong
/// bends the stack, but hardly the direction that the camera changes in.
struct FittedValue {
  std::string image;
  double stated = 0, fitted = 0, deviation = 0;
};

/// Those of one range. Images whose features do not determine it are left out.
std::vector<FittedValue> FitValues(const AdjustmentResult& adjusted,
                                   size_t range, int num_threads);

/// How fitted values depend on stated ones: a polynomial by least trimmed
/// squares (Rousseeuw, "Least Median of Squares Regression", 1984), which
/// nearly half of the images may be far from.
struct ValueRegression {
  /// Residuals, in units of their deviations times what they scatter by.
  std::vector<double> scores;
  /// The scatter of values around the curve, and around one value, in their
  /// deviations; and around the curve in units of the values.
  double scatter = 0, scatter_without = 0, left = 0;
  /// The part of random permutations of the stated values that the fitted ones
  /// depend on as well.
  double chance = 0;
};

/// No scores where there are too few images.
ValueRegression RegressValues(const std::vector<FittedValue>& values);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_VALUE_REGRESSION_H
