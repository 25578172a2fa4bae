#ifndef RAYGRID_CALIBRATION_CAMERA_RESULT_H
#define RAYGRID_CALIBRATION_CAMERA_RESULT_H

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// What a camera was adjusted to, and the figures of its training features.
void FillResult(const Pattern& pattern, const Adjusted& adjusted, int camera,
                int num_threads, CalibrationResult* result);

/// Figures of the held-out residuals, if there are any, and the verdict.
void JudgeResult(CalibrationResult* result);

/// Whether there is more than noise in the errors, and so much that a verdict
/// will say it.
bool NeighborsErrAlike(const CalibrationResult& result);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_RESULT_H
