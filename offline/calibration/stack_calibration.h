#ifndef RAYGRID_CALIBRATION_STACK_CALIBRATION_H
#define RAYGRID_CALIBRATION_STACK_CALIBRATION_H

#include <map>
#include <string>

#include "calibration/calibration.h"
#include "camera/camera_stack.h"

namespace raygrid {

/// The value of a condition in each image, by the image's name.
struct ImageConditions {
  CameraCondition condition = CameraCondition::kLensPosition;
  std::map<std::string, double> values;
};

/// The most terms of a stack's polynomials that so many different values can
/// tell: one for two values, and at most three, so that there are values left
/// to say how well they fit.
int MaxStackOrder(int num_values);

/// Calibrates one camera over the range of a condition: all images in one
/// adjustment, in which each control point is a polynomial of the condition
/// (camera/camera_stack.h). The result's camera is that in the middle of the
/// range, and its training features lie where images show them; held-out
/// errors are those of features brought to the middle of the range. Throws
/// Error as Calibrate() does: kUsage for other models than central-generic, for
/// images without a value, and where all have one value.
RigResult CalibrateStack(const CalibrationInput& input,
                         const ImageConditions& conditions,
                         const Pattern& pattern,
                         const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_STACK_CALIBRATION_H
