#ifndef RAYGRID_CAMERA_MODEL_FITTING_H
#define RAYGRID_CAMERA_MODEL_FITTING_H

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/lens_models.h"

namespace raygrid {

struct FittedModel {
  /// The fitted model, over the area of the camera that it was fitted to.
  std::unique_ptr<ParametricModel> model;
  Eigen::Quaterniond model_from_camera = Eigen::Quaterniond::Identity();
  /// Error that is left, over this part of the lattice, which is fitted best.
  double rms_px = 0;
  static constexpr double kCountedPart = 0.9;
};

/// Choices of a fit.
struct FitOptions {
  /// The model may look elsewhere, as no calibration can tell; the result then
  /// does not depend on the camera's own frame.
  bool free_rotation = false;
  std::vector<std::string> held = {};     ///< parameters that stay 0
  bool ties_focal_lengths = false;        ///< fx = fy
  int num_knots = 24;                     ///< of a central-radial lens's spline
  const ValidityMask* trusted = nullptr;  ///< what counts; null: all
};

/// The parametric model closest to a camera over an area: least squares on how
/// far it projects directions from their pixels, over a lattice of those that
/// the camera knows directions of, and on the lens's distortion: on its tilt
/// (camera/decentring.h), and a little on all of it, so that coefficients that
/// undo each other stay small. Directions that the model cannot have, as
/// OpenCV's behind the camera, have no say. A camera of lines is fitted by
/// their directions.
FittedModel FitParametricModel(const std::string& name,
                               const CameraModel& camera, const Area& area,
                               const FitOptions& options);

/// FitParametricModel(), with a rotation only where more than 0.005 px are left
/// without one, and at least 2 % less with it.
FittedModel FitNearestModel(const std::string& name, const CameraModel& camera,
                            const Area& area, FitOptions options = {});

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_MODEL_FITTING_H
