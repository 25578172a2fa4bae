#ifndef RAYGRID_ADJUSTMENT_COVARIANCE_H
#define RAYGRID_ADJUSTMENT_COVARIANCE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/bundle_adjustment.h"

namespace raygrid {

/// How well a pixel's ray is known.
struct PixelUncertainty {
  Eigen::Vector2d pixel;
  /// Of where a known direction is seen; not numbers where the camera does not
  /// tell.
  Eigen::Matrix2d covariance_px2;
  int num_observations = 0;  ///< nearer to it than to other pixels

  /// In the worse direction.
  double StandardDeviationPx() const;
};

/// For pixels from corner to corner of a camera's area, row by row.
struct UncertaintyOptions {
  int columns = 17, rows = 13;
  int max_exact_unknowns = 2500;
  int num_samples = 128;
};

/// The uncertainty of an adjusted camera: the inverse of the equations' matrix
/// H around the state, with the prior, times the noise's variance, with poses
/// and points as unknown as they were. The camera's orientation, which no
/// observation can see, is the one nearest to the true rays of the pixels that
/// are among observations. Nothing if the equations are singular.
///
/// Up to max_exact_unknowns by a Cholesky factor of H; beyond, where that takes
/// too much time and memory, from samples: adjustments of random residuals to a
/// random prior mean scatter by H^-1. A standard deviation is known to
/// 1 / sqrt(2 num_samples) then, 6 %.
std::vector<PixelUncertainty> ProjectionUncertainty(
    const std::vector<View>& views, const GaussianPrior& prior,
    const AdjustmentOptions& options, double noise_px,
    const AdjustmentState& state, int camera,
    const UncertaintyOptions& lattice = {});

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_COVARIANCE_H
