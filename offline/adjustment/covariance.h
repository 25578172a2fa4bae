#ifndef RAYGRID_ADJUSTMENT_COVARIANCE_H
#define RAYGRID_ADJUSTMENT_COVARIANCE_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/group_jackknife.h"

namespace raygrid {

/// The predicted uncertainty of the projection of a distant point at a pixel.
/// NaN where the camera is undefined.
struct PixelUncertainty {
  Eigen::Vector2d pixel;
  /// Covariance due to feature noise.
  Eigen::Matrix2d noise_px2;
  /// Estimated bias caused by the prior.
  Eigen::Vector2d smoothing_px;
  /// Sum of the covariances due to noise and due to the prior; the latter
  /// covers directions that the observations do not determine.
  Eigen::Matrix2d total_px2;
  /// Factor by which the jackknife scaled the standard deviations.
  double jackknife_scale = 1;
  int num_observations = 0;  ///< observations nearest to this pixel
};

/// Returns the standard deviation of a coordinate (1 sigma), RMS of both axes.
double ComputeAxisStdDev(const Eigen::Matrix2d& covariance);

/// Options of the uncertainty, computed on a lattice of pixels over the
/// calibrated area, row by row.
struct UncertaintyOptions {
  int columns = 17, rows = 13;
  int num_samples = 64;
};

/// Computes the uncertainty of an estimated camera, marginalized over poses and
/// target points. With H = J^T J + P of the normal equations, P the Hessian of
/// the prior and s^2 the noise variance, white noise causes the covariance s^2
/// H^-1 J^T J H^-1 of the parameters, and the prior s^2 H^-1 P H^-1. The bias
/// is H^-1 P (c - c0), evaluated at the estimated parameters; c0 is the prior
/// mean. The gauge, the camera's orientation, is fixed by least squares on the
/// rays of the observations. Per-view deformation is treated as noise, since it
/// is independent in each view.
///
/// Residuals of real images are correlated. The covariance is therefore scaled,
/// in bands of eigenmodes, to the parameter changes observed when groups of
/// frames are left out (GroupJackknife).
///
/// The covariance is exact if the response is exact. Otherwise it is estimated
/// from samples, with a relative standard error of 1 / sqrt(2 num_samples), 9
/// %.
/// @param jackknife of the response; nullptr: white noise is assumed
/// @param joint_px2 receives the joint covariance of x and y of all pixels,
///     whose diagonal blocks are total_px2; may be nullptr
/// @return empty if the normal equations are singular
std::vector<PixelUncertainty> EstimateProjectionUncertainty(
    const LinearResponse& response, double noise_px,
    const GroupJackknife* jackknife, const std::vector<View>& views,
    const AdjustmentState& state, int camera,
    const UncertaintyOptions& lattice = {},
    Eigen::MatrixXd* joint_px2 = nullptr);

/// Computes the lattice's pixels, each with the number of observations nearest
/// to it, and their Jacobian with respect to the camera parameters (2 rows per
/// pixel), after removing the rotation that best aligns the observed points.
/// Rows are zero where the camera is undefined.
Eigen::MatrixXd ComputeLatticeJacobian(const std::vector<View>& views,
                                       const AdjustmentState& state, int camera,
                                       const UncertaintyOptions& lattice,
                                       std::vector<PixelUncertainty>* pixels,
                                       std::vector<bool>* is_known);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_COVARIANCE_H
