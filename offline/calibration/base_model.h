#ifndef RAYGRID_CALIBRATION_BASE_MODEL_H
#define RAYGRID_CALIBRATION_BASE_MODEL_H

#include <string>

#include "calibration/adjustment_result.h"

namespace raygrid {

/// The model of the lenses that grids best lie around, and go on as where
/// nothing is seen: thin-prism-fisheye; or opencv, if the starting lenses
/// are of it and grids around it predict the features clearly better
/// (offline/calibration/DESIGN.md, "Extrapolation").
std::string ChooseBaseModel(const AdjustmentOptions& options,
                            const AdjustmentResult& adjusted);

/// Goes on from starting lenses to those that grids lie around, of the
/// problem's base model, which is chosen if it was not. Where these leave far
/// more than the starting lenses do, the starting lenses stay.
void FitBaseModels(const AdjustmentOptions& options,
                   AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_BASE_MODEL_H
