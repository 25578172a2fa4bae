/// Whether a camera is still the one that was calibrated, by what it sees.
#ifndef RAYGRID_EVALUATION_CAMERA_CHANGE_H
#define RAYGRID_EVALUATION_CAMERA_CHANGE_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"

namespace raygrid {

/// A feature against the projection by the camera as it was calibrated.
struct PlacedFeature {
  Eigen::Vector2d pixel;
  Eigen::Vector2d error_px;             ///< observed - projected
  Eigen::Matrix<double, 2, 6> by_pose;  ///< d projected / d the view's pose
  int column = 0, row = 0;              ///< on its board
};
using PlacedView = std::vector<PlacedFeature>;

/// The known properties of the camera.
struct KnownCamera {
  ImageSize size;
  Area area;
  double focal_px = 0;  ///< of the middle of the image
  double noise_px = 0;  ///< of its features, in an axis
  ErrorModes modes;
};

/// How something may have moved. A parameter is what displaces pixels, in
/// units of its own.
struct Movement {
  std::string name;  ///< "scale", "shift", "tilt", "local"
  std::vector<std::string> parameters;
  std::vector<double> values, deviations;  ///< each with its standard deviation
  double sigmas = 0;                       ///< significance, all else as it was
  /// How much would be found 99 times in a hundred; not told of "local".
  double found_from = 0;
};

struct CameraChange {
  int num_features = 0;
  double noise_px = 0;       ///< as judged by, in an axis
  double smooth_sigmas = 0;  ///< of scale, shift or tilt, whichever is most
  double local_sigmas = 0;
  /// Root mean square displacement that the movements make, less what poses
  /// make up for, and the largest over the image with where that is.
  double rms_px = 0;
  double largest_local_px = 0;
  Eigen::Vector2d largest_local_pixel = Eigen::Vector2d::Zero();
  std::vector<Movement> movements;  ///< scale, shift, tilt, local
  bool is_degraded = false;
  /// Whether a change of scale, or a shift, by a hundredth of the image would
  /// be found 99 times in a hundred; else nothing found means nothing.
  bool can_tell = false;
  std::vector<std::string> moved;  ///< names of what explains it
};

/// Displacements of an unchanged camera are noise, errors of the calibration,
/// with the covariance that its modes have, and those that poses make up for.
/// Any other displacement is tested for being a change of scale, a shift of the
/// image, a tilt of the sensor, or local, on a lattice of 6 x 4; each by
/// generalised least squares. Degraded if one of the four has a probability
/// below 1/1000. One test of all that is smooth would have five degrees of
/// freedom where a shift needs two, and find less.
///
/// Noise is the camera's, or that of the features at hand if they are worse,
/// and counts for more where neighbours err alike.
CameraChange TestForChange(const KnownCamera& camera,
                           const std::vector<PlacedView>& views);

/// How much more than a camera's modes say images of it move that are not of a
/// changed camera, and did not calibrate it: in groups of a few images each, as
/// many as will be tested. What they share beyond noise has causes that no
/// covariance contains: a model that does not follow its lens, errors that
/// features share. Zero for what chance makes once in twenty; otherwise the
/// standard deviation that is larger in one of twenty cases only. If local
/// movements are more than chance, others that are not get the one that is
/// larger in one of six cases.
MovementErrors ErrorsBeyond(
    const KnownCamera& camera,
    const std::vector<std::vector<PlacedView>>& unchanged);

/// How many standard deviations of a normal variable, one-sided, are as rare as
/// a chi-squared variable of this size or more (Wilson, Hilferty, 1931).
double ChiSquaredSigmas(double chi_squared, int freedoms);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CAMERA_CHANGE_H
