/// Cameras that experiments calibrate, from simulated observations or a user's.
#ifndef RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H
#define RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "camera/lens_models.h"
#include "evaluation/calibration_result.h"
#include "experiments/experiment.h"

namespace raygrid {

/// The features to calibrate with, and the images to test with.
struct ExperimentFeatures {
  Dataset dataset;
  Pattern pattern;
  std::vector<std::string> hold_out;
  std::shared_ptr<const CameraModel> truth;  ///< none for a user's features
  std::vector<Condition> conditions;         ///< in words
};

/// The user's features, or else simulated ones: a chessboard of 30 x 24 points,
/// at most 240 of them in an image, 0.05 px of noise. A fifth of the images is
/// held out unless the user says which.
ExperimentFeatures FeaturesFor(const ExperimentOptions& options,
                               const std::string& lens = "example");

/// A model and the part of the image's longer side that a cell is.
struct ModelChoice {
  std::string model;
  /// Along the longer side; 0 for a parametric model, and for a grid whose
  /// cells are chosen by held-out error.
  int cells = 0;

  std::string Label() const;
};

/// Calibrates as `raygrid calibrate` does by default: the board's points are
/// free, those of a simulated board, too.
CalibrationResult CalibrateModel(const ExperimentFeatures& features,
                                 const ModelChoice& choice,
                                 const ExperimentOptions& options);

/// The cells in which a camera is known to kKnownPx, or to the median of its
/// stated deviations if that is more: half of the image counts at least. That
/// is more than what is trusted, which depends on how good the camera is. Of a
/// file that only says where it can be trusted, these cells; nothing if it does
/// not.
std::optional<TrustMask> KnownPart(const CameraFile& file);
constexpr double kKnownPx = 0.1;

/// Cameras that an experiment compares. The last is the truth, or taken for it.
struct ComparedCameras {
  std::vector<NamedCamera> cameras;
  std::vector<Condition> conditions;  ///< also says what the truth is

  const CameraModel& truth() const { return *cameras.back().model; }
};

/// Cameras of the models, calibrated from simulated features, and the true one;
/// or from the user's features, where the last model's is taken for the truth.
/// Of the user's cameras, the last is taken for it; if there is no other,
/// parametric models are fitted to it, where it is known. Throws Error:
/// kInitialization if no model can be calibrated.
ComparedCameras CamerasToCompare(const ExperimentOptions& options,
                                 const std::vector<std::string>& models);

/// The models of a camera as another one knows it: parametric ones fitted to
/// it, where it is known, by any rotation; those that can follow it.
struct FittedCamera {
  NamedCamera camera;
  Eigen::Quaterniond fitted_from_camera;
};
std::vector<FittedCamera> FitModels(const NamedCamera& camera);

/// The area in which all cameras are calibrated.
Area CommonArea(const std::vector<NamedCamera>& cameras);

/// Whether all cameras have a line for the pixel, and a camera taken for the
/// truth is known there.
bool AllKnow(const ComparedCameras& compared, const Eigen::Vector2d& pixel);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H
