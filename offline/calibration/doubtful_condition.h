#ifndef RAYGRID_CALIBRATION_DOUBTFUL_CONDITION_H
#define RAYGRID_CALIBRATION_DOUBTFUL_CONDITION_H

#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/camera_stack.h"

namespace raygrid {

/// A view whose features look as if a condition had another value than was
/// told of the image.
struct DoubtfulCondition {
  std::string image;
  CameraCondition condition = CameraCondition::kLensPosition;
  double told = 0;
  double seems = 0;      ///< within the range
  double doubt = 0;      ///< the difference, in its standard deviations
  int num_decimals = 0;  ///< of what it seems

  /// "front_07.png was told at 9 dioptres, and fits better near 4.2".
  std::string Text() const;
};

/// The views of an adjusted stack whose features tell another value, the most
/// doubtful first. The distance of a board does much of what a longer focal
/// length does, so a wrong value leaves small residuals, and no search for
/// outliers sees it.
std::vector<DoubtfulCondition> FindDoubtfulConditions(const Adjusted& adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DOUBTFUL_CONDITION_H
