/// Cameras calibrated for experiments, from simulated features or a user's.
#ifndef RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H
#define RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "camera/model_registry.h"
#include "evaluation/calibration_result.h"
#include "experiments/experiment.h"

namespace raygrid {

/// The features for calibration, and the held-out images.
struct ExperimentFeatures {
  Dataset dataset;
  Pattern pattern;
  std::vector<std::string> hold_out;
  std::shared_ptr<const CameraModel> truth;  ///< NULL for a user's features
  std::vector<Condition> conditions;         ///< descriptions
};

/// Returns the user's features, or simulates a chessboard of 30 x 24 points, at
/// most 240 of them in an image, 0.05 px of noise. A fifth of the images is
/// held out unless the user specifies it.
ExperimentFeatures SelectFeatures(const ExperimentOptions& options,
                                  const std::string& lens = "example");

/// A model, and its knot spacing relative to the longer image side.
struct ModelChoice {
  std::string model;
  /// Number of cells along the longer side; 0 for a parametric model, and for a
  /// grid whose knot spacing is selected by held-out error.
  int cells = 0;

  std::string Label() const;
};

/// Calibrates like `raygrid calibrate` with default options: target points are
/// estimated, even for simulated boards.
CalibrationResult CalibrateModel(const ExperimentFeatures& features,
                                 const ModelChoice& choice,
                                 const ExperimentOptions& options);

/// Returns the cells with a predicted uncertainty below kKnownPx, or below the
/// median if that is larger, so at least half of the image. This is larger than
/// the valid region, which depends on the camera's quality. For a file with
/// only a validity mask, that mask; nullopt without one.
std::optional<ValidityMask> ComputeWellDeterminedMask(const CameraFile& file);
constexpr double kKnownPx = 0.1;

/// Cameras compared in an experiment. The last is the reference: the truth, or
/// assumed to be true.
struct ComparedCameras {
  std::vector<NamedCamera> cameras;
  std::vector<Condition> conditions;  ///< also describes the reference

  const CameraModel& truth() const { return *cameras.back().model; }
};

/// Calibrates the models from simulated features and adds the true camera; or
/// from the user's features, with the last model as the reference. Of the
/// user's cameras, the last is the reference; if it is the only one, parametric
/// models are fitted to it in its valid region. Throws Error:
/// kInitializationFailed if no model can be calibrated.
ComparedCameras SelectComparedCameras(const ExperimentOptions& options,
                                      const std::vector<std::string>& models);

/// A parametric model fitted to another camera in its valid region, with the
/// estimated rotation between both.
struct FittedCamera {
  NamedCamera camera;
  Eigen::Quaterniond fitted_from_camera;
};
std::vector<FittedCamera> FitModels(const NamedCamera& camera);

/// Returns the area in which all cameras are calibrated.
Area ComputeCommonArea(const std::vector<NamedCamera>& cameras);

/// Returns whether all cameras have a line for the pixel, and it is in the
/// valid region of an assumed reference.
bool AreAllDefined(const ComparedCameras& compared,
                   const Eigen::Vector2d& pixel);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H
