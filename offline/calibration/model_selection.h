#ifndef RAYGRID_CALIBRATION_MODEL_SELECTION_H
#define RAYGRID_CALIBRATION_MODEL_SELECTION_H

#include <map>
#include <string>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Value of CalibrationOptions::model for selection by held-out error.
constexpr char kAutoModel[] = "auto";

/// Trials of a camera's folds by model.
using ModelTrials = std::map<std::string, std::vector<Trial>>;

struct ModelSelection {
  std::string model;
  std::vector<ModelTrials> trials;   ///< trials of each camera's folds, if any
  bool fix_target_geometry = false;  ///< in the trials of other models
};

/// Selects by cross-validation between the central grid with its selected knot
/// spacing and parametric models: one parametric model for all cameras, if it
/// predicts held-out features of each camera better than the grid, by a
/// standard error; with options.allow_noncentral the non-central grid, if it is
/// better by two standard errors. Adds all candidates to each camera's result.
ModelSelection SelectModel(const Pattern& pattern,
                           const CalibrationOptions& options,
                           std::vector<CameraInProgress>* cameras);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MODEL_SELECTION_H
