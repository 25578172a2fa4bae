#ifndef RAYGRID_REPORT_UNCERTAINTY_PICTURE_H
#define RAYGRID_REPORT_UNCERTAINTY_PICTURE_H

#include "camera/area.h"
#include "camera/camera_uncertainty.h"
#include "dataset/image_files.h"

namespace raygrid {

/// Standard deviations of the projection over the area, with a legend below, in
/// colours that the colour-blind read too; hatched where the camera cannot be
/// trusted, grey outside the area. 800 px wide.
Image UncertaintyPicture(const CameraUncertainty& uncertainty,
                         const ImageSize& size, const Area& area);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_UNCERTAINTY_PICTURE_H
