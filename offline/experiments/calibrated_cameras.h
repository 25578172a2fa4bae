/// Cameras that experiments calibrate, from simulated observations or a user's.
#ifndef RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H
#define RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H

#include <memory>
#include <string>
#include <vector>

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
  int cells = 0;  ///< along the longer side; 0 for a parametric model

  std::string Label() const;
};

CalibrationResult CalibrateModel(const ExperimentFeatures& features,
                                 const ModelChoice& choice,
                                 const ExperimentOptions& options);

/// The area in which all cameras are calibrated.
Area CommonArea(const std::vector<NamedCamera>& cameras);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_CALIBRATED_CAMERAS_H
