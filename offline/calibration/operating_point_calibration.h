#ifndef RAYGRID_CALIBRATION_OPERATING_POINT_CALIBRATION_H
#define RAYGRID_CALIBRATION_OPERATING_POINT_CALIBRATION_H

#include <map>
#include <string>

#include "calibration/calibration.h"
#include "camera/operating_point_model.h"

namespace raygrid {

/// The values of conditions in each image, by the image's name. A lens position
/// comes before a temperature.
struct ImageOperatingPoints {
  std::vector<OperatingParameter> conditions;
  std::map<std::string, OperatingPoint> values;
};

/// The most terms of a condition's polynomial that so many different values can
/// tell: one for two values, and at most three, so that there are values left
/// to say how well they fit.
int MaxPolynomialOrder(int num_values);

/// Throws InputError if an image and a copy of it, by their names, have
/// different values.
void RequireConsistentValues(const ImageOperatingPoints& conditions,
                             const std::string& image, const std::string& copy);

/// Calibrates one camera over the ranges of conditions: all images in one
/// adjustment, in which each control point is a sum of polynomials of the
/// conditions (camera/operating_point_model.h). The result's camera is that in
/// the middle of the ranges, and its training features lie where images show
/// them; held-out errors are those of features brought to the middle. Throws
/// Error as Calibrate() does: kUsage for other models than central-generic, for
/// images without a value, where all have one value of a condition, and where
/// two conditions go together.
RigResult CalibrateOperatingPoints(const CalibrationInput& input,
                                   const ImageOperatingPoints& conditions,
                                   const Pattern& pattern,
                                   const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_OPERATING_POINT_CALIBRATION_H
