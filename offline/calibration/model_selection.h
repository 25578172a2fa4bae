#ifndef RAYGRID_CALIBRATION_MODEL_SELECTION_H
#define RAYGRID_CALIBRATION_MODEL_SELECTION_H

#include <string>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// CalibrationOptions::model for the model that predicts held-out images best.
constexpr char kAutoModel[] = "auto";

/// Chooses between the central grid whose cells are chosen and parametric
/// models, by cross-validation: one parametric model for all cameras, if it
/// predicts held-out features better than the grid for each of them, by a
/// standard error; with
/// options.allow_noncentral the non-central grid, if it is better by two
/// standard errors. Lists what was tried in each camera's result.
std::string SelectModel(const Pattern& pattern,
                        const CalibrationOptions& options,
                        std::vector<CameraInProgress>* cameras);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MODEL_SELECTION_H
