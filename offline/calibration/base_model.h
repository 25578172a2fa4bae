#ifndef RAYGRID_CALIBRATION_BASE_MODEL_H
#define RAYGRID_CALIBRATION_BASE_MODEL_H

#include <string>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// Returns the name of the base model of grids, which determines their
/// extrapolation: thin-prism-fisheye; or opencv, if the initial cameras are
/// opencv and grids around it predict the features clearly better
/// (offline/calibration/DESIGN.md, "Extrapolation").
std::string ChooseBaseModel(const AdjustmentOptions& options,
                            const AdjustmentResult& adjusted);

/// Fits base models to the features, starting from the initial cameras. The
/// problem's base model is chosen first if it is not set. An initial camera is
/// kept if the residuals of the fitted model are far larger.
void FitBaseModels(const AdjustmentOptions& options,
                   AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_BASE_MODEL_H
