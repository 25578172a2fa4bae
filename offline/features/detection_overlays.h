#ifndef RAYGRID_FEATURES_DETECTION_OVERLAYS_H
#define RAYGRID_FEATURES_DETECTION_OVERLAYS_H

#include "features/board_view/detection.h"

namespace raygrid {

/// Draws the image, enlarged if small, with its detection: a green cross at
/// each feature, a line to the next one in its row, a circle around the board's
/// first one, rejected features in red with the reason, and warnings.
Image DrawDetection(const GreyImage& image, const ImageDetection& detection);

/// Draws a heat map of the number of features per image region over all images,
/// with a colour bar.
Image DrawCoverage(const Dataset& dataset);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_DETECTION_OVERLAYS_H
