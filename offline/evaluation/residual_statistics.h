#ifndef RAYGRID_EVALUATION_RESIDUAL_STATISTICS_H
#define RAYGRID_EVALUATION_RESIDUAL_STATISTICS_H

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dataset/camera_file.h"

namespace raygrid {

/// A feature, where the calibrated camera projects it, and where it belongs.
struct FeatureResidual {
  std::string image;
  int board = 0, column = 0, row = 0;
  Eigen::Vector2d pixel;     ///< observed
  Eigen::Vector2d error_px;  ///< projected - observed
};

/// The p-quantile (0 to 1) of values, which are reordered; linear between
/// order statistics. 0 for none.
double Quantile(std::vector<double> values, double p);

ErrorFigures ComputeErrorFigures(const std::vector<FeatureResidual>& residuals);

/// How far the residuals of a place are from pure noise: the median, over a
/// 50 x 50 grid of the area, of the Kullback-Leibler divergence of a cell's
/// normalised residuals (8 x 8 histogram) from a standard normal distribution
/// (paper, "Camera Model Validation"). Cells with fewer than 5 residuals do
/// not count; nothing if none has as many.
std::optional<double> ComputeBias(const std::vector<FeatureResidual>& residuals,
                                  const Area& area);

/// The bias that pure noise would have in the same places: a histogram of a few
/// residuals is never quite the distribution that they are drawn from.
std::optional<double> NoiseBias(const std::vector<FeatureResidual>& residuals,
                                const Area& area);

/// The divergence of each cell, row by row, not a number in cells with fewer
/// than 5 residuals.
constexpr int kBiasCells = 50;  ///< along each side
std::vector<double> BiasOfCells(const std::vector<FeatureResidual>& residuals,
                                const Area& area);

/// The correlation of residuals of features that are neighbours on a board in
/// one image: 0 for noise, near 1 where the errors are the model's. Nothing for
/// too few neighbours to tell.
std::optional<double> NeighborCorrelation(
    const std::vector<FeatureResidual>& residuals);

/// Images whose features err many times more than those of the others, by
/// their medians: another camera's, or of another board.
std::set<std::string> ImagesApart(
    const std::vector<FeatureResidual>& residuals);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_RESIDUAL_STATISTICS_H
