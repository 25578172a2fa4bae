#ifndef RAYGRID_ADJUSTMENT_COVARIANCE_H
#define RAYGRID_ADJUSTMENT_COVARIANCE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/bundle_adjustment.h"

namespace raygrid {

/// How well a pixel's ray is known: of where a known direction is seen. Not
/// numbers where the camera does not tell.
struct PixelUncertainty {
  Eigen::Vector2d pixel;
  /// How it would scatter, were the noise drawn anew.
  Eigen::Matrix2d noise_px2;
  /// The move of the pixel by the prior, as estimated: noise apart, the error.
  Eigen::Vector2d smoothing_px;
  /// How far it may be from the truth: also what the prior leaves open where
  /// observations do not tell.
  Eigen::Matrix2d total_px2;
  int num_observations = 0;  ///< nearer to it than to other pixels
};

/// Standard deviation in the worse direction.
double WorseDeviation(const Eigen::Matrix2d& covariance);

/// The options of the uncertainty at pixels from corner to corner of a camera's
/// area, row by row.
struct UncertaintyOptions {
  int columns = 17, rows = 13;
  int max_exact_unknowns = 2500;
  int num_samples = 64;
};

/// The uncertainty of an adjusted camera, with poses and points as unknown as
/// they were. H = J^T J + P being the equations' matrix around the state, with
/// the prior P, and s^2 the noise's variance, parameters are s^2 H^-1 from the
/// truth if the prior holds, and scatter by s^2 H^-1 J^T J H^-1 with the noise.
/// Their mean is H^-1 P (c - c0) from the truth c, of which the adjusted
/// parameters are an estimate; c0 is the prior's mean.
/// The camera's orientation, which no observation can see, is the one nearest
/// to the true rays of the pixels that are among observations. Nothing if the
/// equations are singular. The flex of a view counts as noise, being drawn anew
/// with each view: H^-1 (J^T J + its prior) H^-1.
///
/// Up to max_exact_unknowns by factoring H; beyond, where that takes too much
/// time and memory, from samples: adjustments to random residuals and around a
/// random prior mean. A standard deviation is known to 1 / sqrt(2 num_samples)
/// then, 9 %.
///
/// joint_px2, if given, is what total_px2 is a part of: the covariance of all
/// pixels' x and y.
std::vector<PixelUncertainty> ProjectionUncertainty(
    const std::vector<View>& views, const GaussianPrior& prior,
    const AdjustmentOptions& options, double noise_px,
    const AdjustmentState& state, int camera,
    const UncertaintyOptions& lattice = {},
    Eigen::MatrixXd* joint_px2 = nullptr);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_COVARIANCE_H
