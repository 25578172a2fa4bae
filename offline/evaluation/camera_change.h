/// Tests whether images are consistent with an existing calibration.
#ifndef RAYGRID_EVALUATION_CAMERA_CHANGE_H
#define RAYGRID_EVALUATION_CAMERA_CHANGE_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"

namespace raygrid {

/// A feature, and its reprojection error with the existing calibration.
struct ProjectedFeature {
  Eigen::Vector2d pixel;
  Eigen::Vector2d error_px;            ///< observed - projected
  Eigen::Matrix<double, 2, 6> J_pose;  ///< Jacobian by the view's pose
  int column = 0, row = 0;             ///< position on the board
};
using ProjectedView = std::vector<ProjectedFeature>;

/// The existing calibration, with its uncertainty.
struct ReferenceCamera {
  ImageSize size;
  Area area;
  double focal_px = 0;  ///< focal length at the image centre
  double noise_px = 0;  ///< feature noise, per coordinate
  ErrorModes modes;
};

/// A type of change. Its parameters cause pixel displacements and have
/// different units.
struct Movement {
  std::string name;  ///< "scale", "shift", "tilt", "local"
  std::vector<std::string> parameters;
  std::vector<double> values, deviations;  ///< values and standard deviations
  double sigmas = 0;  ///< significance of this change alone
  /// Magnitude that is detected with a probability of 99 %; not for "local".
  double detection_limit = 0;
};

struct CameraChange {
  int num_features = 0;
  double noise_px = 0;       ///< used in the test, per coordinate
  double smooth_sigmas = 0;  ///< largest significance of scale, shift and tilt
  double local_sigmas = 0;
  /// RMS displacement caused by the change, after re-estimating the poses;
  /// maximum over the image, and its position.
  double rms_px = 0;
  double max_local_px = 0;
  Eigen::Vector2d max_local_pixel = Eigen::Vector2d::Zero();
  std::vector<Movement> movements;  ///< scale, shift, tilt, local
  bool is_degraded = false;
  /// Whether a change of scale, or a shift, by 1 % would be detected with a
  /// probability of 99 %; otherwise a negative result is inconclusive.
  bool is_conclusive = false;
  std::vector<std::string> moved;  ///< names of significant changes
};

/// For an unchanged camera, displacements consist of noise, calibration errors
/// with the covariance of its modes, and displacements compensated by poses.
/// The remainder is tested for a change of scale, a shift of the image, a tilt
/// of the sensor, and local changes on a 6 x 4 lattice; each by generalized
/// least squares. The camera is degraded if one of the four has p < 1/1000. A
/// single test of all smooth changes would have five degrees of freedom where a
/// shift has two, and thus less power.
///
/// The noise is the larger one of calibration and current features, and is
/// inflated for correlated residuals.
CameraChange TestCameraChange(const ReferenceCamera& camera,
                              const std::vector<ProjectedView>& views);

/// Estimates the displacement errors of an unchanged camera beyond its
/// covariance, from images that were not used for the calibration, in groups of
/// the size to be tested. Their common errors, beyond noise, have causes that
/// the covariance does not include: model errors and correlated feature errors.
/// Zero if insignificant (p > 0.05); otherwise the upper 95 % limit of the
/// standard deviation. If local changes are significant, insignificant others
/// are set to the limit with an exceedance probability of 1/6.
MovementErrors ComputeExcessErrors(
    const ReferenceCamera& camera,
    const std::vector<std::vector<ProjectedView>>& unchanged);

/// Converts a chi-squared value to a one-sided normal quantile of equal
/// probability (Wilson, Hilferty, 1931).
double ChiSquaredSigmas(double chi_squared, int degrees_of_freedom);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CAMERA_CHANGE_H
