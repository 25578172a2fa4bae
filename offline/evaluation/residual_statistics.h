#ifndef RAYGRID_EVALUATION_RESIDUAL_STATISTICS_H
#define RAYGRID_EVALUATION_RESIDUAL_STATISTICS_H

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dataset/camera_file.h"

namespace raygrid {

/// A feature's reprojection error, with its image and board.
struct FeatureResidual {
  std::string image;
  int board = 0, column = 0, row = 0;
  Eigen::Vector2d pixel;     ///< observed
  Eigen::Vector2d error_px;  ///< projected - observed
};

/// Returns the p-quantile (0 to 1) of values, which are reordered; linear
/// interpolation between order statistics. 0 if empty.
double Quantile(std::vector<double> values, double p);

ErrorMetrics ComputeErrorMetrics(const std::vector<FeatureResidual>& residuals);

/// Computes the bias of residuals in a region: the median, over a 50 x 50 grid
/// of the area, of the Kullback-Leibler divergence of a cell's normalized
/// residuals (8 x 8 histogram) from a standard normal distribution (paper,
/// "Camera Model Validation"). Cells with fewer than 5 residuals are ignored;
/// nullopt if there are no other cells.
std::optional<double> ComputeBias(const std::vector<FeatureResidual>& residuals,
                                  const Area& area);

/// Computes the bias expected for pure noise at the same positions, due to the
/// finite number of residuals per histogram.
std::optional<double> ComputeNoiseBias(
    const std::vector<FeatureResidual>& residuals, const Area& area);

/// Computes the divergence of each cell, row by row; NaN in cells with fewer
/// than 5 residuals.
constexpr int kBiasCells = 50;  ///< along each side
std::vector<double> ComputeCellBias(
    const std::vector<FeatureResidual>& residuals, const Area& area);

/// Computes the correlation of residuals of neighbouring features on a board in
/// one image: 0 for white noise, near 1 for model errors. nullopt if there are
/// too few neighbours.
std::optional<double> ComputeNeighborCorrelation(
    const std::vector<FeatureResidual>& residuals);

/// Computes the RMS, in px, of the part of the residuals that is the same in
/// all images: a function of the position in the image, as wrong intrinsics
/// cause it. Estimated without bias by noise, from products of the mean
/// residuals of different images in the same cell (10 x 10 cells of the area).
/// nullopt if fewer than five images have residuals.
std::optional<double> ComputeSystematicError(
    const std::vector<FeatureResidual>& residuals, const Area& area);

/// Finds images whose median residual is many times the median of the other
/// images: outliers, from another camera or another board.
std::set<std::string> FindOutlierImages(
    const std::vector<FeatureResidual>& residuals);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_RESIDUAL_STATISTICS_H
