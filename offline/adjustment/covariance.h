#ifndef RAYGRID_ADJUSTMENT_COVARIANCE_H
#define RAYGRID_ADJUSTMENT_COVARIANCE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/bundle_adjustment.h"

namespace raygrid {

/// How well a pixel's ray is known.
struct PixelUncertainty {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2;  ///< of where a known direction is seen
  int num_observations = 0;        ///< nearer to it than to other pixels

  /// In the worse direction.
  double StandardDeviationPx() const;
};

/// Pixels from corner to corner of a camera's area, row by row.
struct UncertaintyLattice {
  int columns = 16, rows = 12;
};

/// The uncertainty of an adjusted camera: the inverse of the equations' matrix
/// around the state, with the prior, times the noise's variance, with poses and
/// points as unknown as they were. The camera's orientation, which no
/// observation can see, is the one nearest to the true rays of the pixels that
/// are among observations. Nothing if the equations are singular.
std::vector<PixelUncertainty> ProjectionUncertainty(
    const std::vector<View>& views, const GaussianPrior& prior,
    const AdjustmentOptions& options, double noise_px,
    const AdjustmentState& state, int camera,
    const UncertaintyLattice& lattice = {});

/// Where the camera can be trusted to max_px: pixels among observations, with
/// no larger standard deviation.
std::vector<bool> TrustMask(const std::vector<PixelUncertainty>& pixels,
                            double max_px);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_COVARIANCE_H
