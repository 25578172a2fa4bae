#ifndef RAYGRID_ADJUSTMENT_COVARIANCE_H
#define RAYGRID_ADJUSTMENT_COVARIANCE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/shared_noise.h"

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
  int num_samples = 64;
};

/// The uncertainty of an adjusted camera, with poses and points as unknown as
/// they were. H = J^T J + P being the equations' matrix around the state, with
/// the prior P, s^2 the variance that adjustment found and N the covariance of
/// the observations' noise, parameters scatter by H^-1 J^T N J H^-1 with the
/// noise, and are from the truth by s^2 H^-1 P H^-1 besides if the prior holds:
/// together by s^2 H^-1 if the noise is white. Their mean is H^-1 P (c - c0)
/// from the truth c, of which the adjusted parameters are an estimate; c0 is
/// the prior's mean.
/// The camera's orientation, which no observation can see, is the one nearest
/// to the true rays of the observations. Nothing if the
/// equations are singular. The flex of a view counts as noise, being drawn anew
/// with each view: its prior stands beside J^T N J.
///
/// Exact where the response is, but for noise that neighbours share: that, and
/// all where the response is not exact, is told by samples. A standard
/// deviation is known to 1 / sqrt(2 num_samples) then, 9 %.
///
/// joint_px2, if given, is what total_px2 is a part of: the covariance of all
/// pixels' x and y.
std::vector<PixelUncertainty> ProjectionUncertainty(
    const LinearResponse& response, const ObservationNoise& noise,
    const std::vector<View>& views, const AdjustmentState& state, int camera,
    const UncertaintyOptions& lattice = {},
    Eigen::MatrixXd* joint_px2 = nullptr);

/// The lattice's pixels, each with the number of observations that are nearest
/// to it, and how they move with the camera's parameters, two rows each, but
/// for a rotation that all share: that of least squares over the observations.
/// No move where the camera does not tell.
Eigen::MatrixXd MovesOfLattice(const std::vector<View>& views,
                               const AdjustmentState& state, int camera,
                               const UncertaintyOptions& lattice,
                               std::vector<PixelUncertainty>* pixels,
                               std::vector<bool>* is_known);

/// How some pixels among observations move with the camera's parameters, two
/// rows each, but for a rotation that all share.
Eigen::MatrixXd MovesOfSeenPixels(const std::vector<View>& views,
                                  const AdjustmentState& state, int camera,
                                  const UncertaintyOptions& lattice = {});

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_COVARIANCE_H
