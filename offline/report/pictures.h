#ifndef RAYGRID_REPORT_PICTURES_H
#define RAYGRID_REPORT_PICTURES_H

#include <vector>

#include "dataset/image_files.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {

/// Where in the image features were seen, and the calibrated area.
Image CoveragePicture(const std::vector<FeatureResidual>& residuals,
                      const ImageSize& size, const Area& area);

/// Each pixel of the area in the colour of the nearest residual (a Voronoi
/// diagram): its direction as hue (paper, "Camera Model Validation"; a pattern
/// shows that the model does not fit the camera), or its magnitude, dark for 0
/// and bright for full_scale_px.
Image DirectionPicture(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area);
Image MagnitudePicture(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area,
                       double full_scale_px);

/// A wheel of the direction picture's hues.
Image DirectionLegend(int size_px);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PICTURES_H
