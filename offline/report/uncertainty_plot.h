#ifndef RAYGRID_REPORT_UNCERTAINTY_PLOT_H
#define RAYGRID_REPORT_UNCERTAINTY_PLOT_H

#include "camera/area.h"
#include "camera/camera_uncertainty.h"
#include "dataset/image_files.h"

namespace raygrid {

/// Draws the predicted uncertainty over the area, with a legend below, in
/// colours readable with colour blindness; hatched outside the valid region,
/// grey outside the area. 800 px wide.
Image DrawUncertaintyPlot(const CameraUncertainty& uncertainty,
                          const ImageSize& size, const Area& area);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_UNCERTAINTY_PLOT_H
