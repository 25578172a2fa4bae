#ifndef RAYGRID_REPORT_PICTURES_H
#define RAYGRID_REPORT_PICTURES_H

#include <vector>

#include "dataset/image_files.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {

/// The places in the image where features were seen, and the calibrated area.
Image CoveragePicture(const std::vector<FeatureResidual>& residuals,
                      const ImageSize& size, const Area& area);

/// Each pixel of the area in the colour of the nearest residual (a Voronoi
/// diagram): its direction as a colour (paper, "Camera Model Validation"; a
/// pattern shows that the model does not fit the camera), or its magnitude,
/// dark for 0 and bright for full_scale_px.
Image DirectionPicture(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area);
Image MagnitudePicture(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area,
                       double full_scale_px);

/// A wheel of the direction picture's colours.
Image DirectionLegend(int size_px);

/// The divergence from noise of each cell of the area, white where there are
/// too few residuals.
Image BiasPicture(const std::vector<FeatureResidual>& residuals,
                  const Area& area, double full_scale);

/// Displacements of cells of an area, row by row: their sizes in colours from
/// 0, dark, to full_scale_px, with arrows over them. Arrows of the full scale
/// are as long as they are apart. White cells have none.
Image DisplacementPicture(const std::vector<Eigen::Vector2d>& displacements,
                          int columns, double full_scale_px);

/// The image, made smaller if it is wider.
Image Shrunk(const Image& image, int max_width_px);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PICTURES_H
