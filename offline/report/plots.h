#ifndef RAYGRID_REPORT_PLOTS_H
#define RAYGRID_REPORT_PLOTS_H

#include <vector>

#include "dataset/image_files.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {

/// Draws the positions of features in the image, and the calibrated area.
Image DrawCoveragePlot(const std::vector<FeatureResidual>& residuals,
                       const ImageSize& size, const Area& area);

/// Draws each pixel of the area in the colour of the nearest residual (a
/// Voronoi diagram): its direction as hue (paper, "Camera Model Validation"; a
/// pattern indicates a model error), or its magnitude, from dark for 0 to
/// bright for full_scale_px.
Image DrawDirectionPlot(const std::vector<FeatureResidual>& residuals,
                        const ImageSize& size, const Area& area);
Image DrawMagnitudePlot(const std::vector<FeatureResidual>& residuals,
                        const ImageSize& size, const Area& area,
                        double full_scale_px);

/// Draws the legend of the direction picture: a colour wheel.
Image DrawDirectionLegend(int size_px);

/// Draws the divergence of residuals from noise in each cell of the area; white
/// for cells with too few residuals.
Image DrawBiasPlot(const std::vector<FeatureResidual>& residuals,
                   const Area& area, double full_scale);

/// Draws displacements of the cells of an area, row by row: magnitudes as
/// colours from 0, dark, to full_scale_px, with arrows. A full-scale arrow has
/// the length of the arrows' spacing. Cells without data are white.
Image DrawDisplacementPlot(const std::vector<Eigen::Vector2d>& displacements,
                           int columns, double full_scale_px);

/// Scales the image down if it is wider.
Image ShrinkImage(const Image& image, int max_width_px);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PLOTS_H
