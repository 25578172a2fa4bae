#ifndef RAYGRID_FEATURES_DETECTION_PICTURES_H
#define RAYGRID_FEATURES_DETECTION_PICTURES_H

#include "features/board_view/detection.h"

namespace raygrid {

/// The image, enlarged if it is small, with what was found in it: a green cross
/// at each feature, a line to the next one of its row, a circle around the
/// board's first, rejected features in red with the reason, remarks at the top.
Image DrawDetection(const GreyImage& image, const ImageDetection& detection);

/// How many features the images have in each part of the image, with a scale:
/// where there are few, a calibration knows little.
Image DrawCoverage(const Dataset& dataset);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_DETECTION_PICTURES_H
