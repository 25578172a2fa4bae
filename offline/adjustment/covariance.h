#ifndef RAYGRID_ADJUSTMENT_COVARIANCE_H
#define RAYGRID_ADJUSTMENT_COVARIANCE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/group_jackknife.h"

namespace raygrid {

/// How well a pixel's ray is known: of where a known direction is seen. Not
/// numbers where the camera is undefined.
struct PixelUncertainty {
  Eigen::Vector2d pixel;
  /// How it would scatter, were the noise drawn anew.
  Eigen::Matrix2d noise_px2;
  /// The move of the pixel by the prior, as estimated: noise apart, the error.
  Eigen::Vector2d smoothing_px;
  /// How far it may be from the truth: also what the prior leaves open where
  /// observations do not tell.
  Eigen::Matrix2d total_px2;
  /// By how much the jackknife scaled the standard deviation of total_px2.
  double jackknife_scale = 1;
  int num_observations = 0;  ///< nearer to it than to other pixels
};

/// Standard deviation of a coordinate: the RMS of both axes.
double AxisDeviation(const Eigen::Matrix2d& covariance);

/// The options of the uncertainty at pixels from corner to corner of a camera's
/// area, row by row.
struct UncertaintyOptions {
  int columns = 17, rows = 13;
  int num_samples = 64;
};

/// The uncertainty of an adjusted camera, with poses and points as unknown as
/// they were. With H = J^T J + P of the normal equations, the prior precision P
/// and the noise variance s^2, white noise gives the parameters the covariance
/// s^2 H^-1 J^T J H^-1, and the prior s^2 H^-1 P H^-1 besides. Their mean is
/// H^-1 P (c - c0) from the truth c, of which the adjusted parameters are an
/// estimate; c0 is the prior's mean. The gauge, the camera's orientation, is
/// fixed by least squares to the true rays of the observations. The flex of a
/// view counts as noise, being drawn anew with each view.
///
/// Residuals of real images are not white. So the covariance over the lattice
/// is scaled mode by mode until it predicts how much the camera changes if
/// groups of frames are left out (GroupJackknife).
///
/// Exact where the response is; else by samples, which determine a standard
/// deviation to 1 / sqrt(2 num_samples), 9 %.
///
/// @param jackknife of the response; nullptr: the noise is white
/// @param joint_px2 the covariance of all pixels' x and y, of which total_px2
///     is a part; may be nullptr
/// @return empty if the equations are singular
std::vector<PixelUncertainty> ProjectionUncertainty(
    const LinearResponse& response, double noise_px,
    const GroupJackknife* jackknife, const std::vector<View>& views,
    const AdjustmentState& state, int camera,
    const UncertaintyOptions& lattice = {},
    Eigen::MatrixXd* joint_px2 = nullptr);

/// The lattice's pixels, each with the number of observations that are nearest
/// to it, and how they move with the camera's parameters, two rows each, but
/// for a rotation that all share: that of least squares over the observations.
/// No move where the camera is undefined.
Eigen::MatrixXd MovesOfLattice(const std::vector<View>& views,
                               const AdjustmentState& state, int camera,
                               const UncertaintyOptions& lattice,
                               std::vector<PixelUncertainty>* pixels,
                               std::vector<bool>* is_known);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_COVARIANCE_H
