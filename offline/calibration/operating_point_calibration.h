#ifndef RAYGRID_CALIBRATION_OPERATING_POINT_CALIBRATION_H
#define RAYGRID_CALIBRATION_OPERATING_POINT_CALIBRATION_H

#include <map>
#include <string>

#include "calibration/calibration.h"
#include "camera/operating_point_model.h"

namespace raygrid {

/// Operating points by image name. A lens position comes before a temperature.
struct ImageOperatingPoints {
  std::vector<OperatingParameter> conditions;
  std::map<std::string, OperatingPoint> values;
};

/// Returns the maximum number of polynomial terms for a variable with
/// num_values different values: one for two values, three at most, so that some
/// values remain to test the fit.
int MaxPolynomialOrder(int num_values);

/// Throws InputError if an image and its duplicate (matched by file name) have
/// different operating points.
void RequireConsistentValues(const ImageOperatingPoints& conditions,
                             const std::string& image, const std::string& copy);

/// Calibrates one camera over the ranges of operating-point variables: all
/// images in one adjustment, in which each control point is a polynomial of the
/// variables (camera/operating_point_model.h). The result's camera is at the
/// mid-range, and its training features are as observed; held-out errors
/// refer to features mapped to the mid-range. Throws Error as Calibrate() does:
/// kUsage for models other than central-generic, images without a value, a
/// variable with only one value, and two variables that are correlated.
RigResult CalibrateOperatingPoints(const CalibrationInput& input,
                                   const ImageOperatingPoints& conditions,
                                   const Pattern& pattern,
                                   const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OPERATING_POINT_CALIBRATION_H
