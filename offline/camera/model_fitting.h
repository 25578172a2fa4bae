#ifndef RAYGRID_CAMERA_MODEL_FITTING_H
#define RAYGRID_CAMERA_MODEL_FITTING_H

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/model_registry.h"

namespace raygrid {

struct FittedModel {
  /// The fitted model, over the area of the original camera.
  std::unique_ptr<ParametricModel> model;
  Eigen::Quaterniond model_from_camera = Eigen::Quaterniond::Identity();
  /// RMS error over this fraction of the lattice, the pixels with least error.
  double rms_px = 0;
  static constexpr double kInlierFraction = 0.9;
};

/// Options of FitParametricModel().
struct FitOptions {
  /// Estimates the model's rotation, too, which no calibration can determine;
  /// the result then does not depend on the camera's frame.
  bool free_rotation = false;
  std::vector<std::string> held = {};  ///< parameters that are fixed to 0
  bool ties_focal_lengths = false;     ///< fx = fy
  int num_knots = 24;                  ///< control points of central-radial
  const ValidityMask* valid_region = nullptr;  ///< valid region; null: all
};

/// Fits a parametric model to a camera over an area: least squares of projected
/// directions, over a lattice of pixels with directions. Tilt and tangential
/// terms are regularized (camera/decentring.h), as are, weakly, all distortion
/// terms, so that coefficients that compensate each other stay small.
/// Directions that the model cannot represent, such as directions behind an
/// opencv camera, are ignored. Non-central cameras are fitted by their
/// directions.
FittedModel FitParametricModel(const std::string& name,
                               const CameraModel& camera, const Area& area,
                               const FitOptions& options);

/// Like FitParametricModel(), but estimates a rotation only if the error
/// without it exceeds 0.005 px and the rotation reduces it by at least 2 %.
FittedModel FitNearestModel(const std::string& name, const CameraModel& camera,
                            const Area& area, FitOptions options = {});

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_MODEL_FITTING_H
