#ifndef RAYGRID_CALIBRATION_CAMERA_RESULT_H
#define RAYGRID_CALIBRATION_CAMERA_RESULT_H

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// The residuals of the features that a camera was adjusted to.
std::vector<FeatureResidual> ComputeTrainingResiduals(
    const Pattern& pattern, const AdjustmentResult& adjusted, int camera,
    int num_threads);

/// Fills in the adjusted camera, which has the image circle if that is known,
/// and the figures of its training features.
void FillResult(const Pattern& pattern, const AdjustmentResult& adjusted,
                int camera, const std::optional<ImageCircle>& image_circle,
                int num_threads, CalibrationResult* result);

/// Fills in the predicted uncertainty, the valid region and what is
/// extrapolated (EstimateUncertainty()). What FillResult() fills in is there,
/// and is left alone.
void FillUncertainty(const AdjustmentResult& adjusted, int camera,
                     const std::optional<ImageCircle>& image_circle,
                     const std::optional<double>& valid_limit_px,
                     int num_threads, CalibrationResult* result);

/// Names the images whose held-out errors are large because they alone show
/// some places: their own training errors are no larger than those of others,
/// and their held-out errors no larger than the equations say.
void FindUniqueCoverageImages(const AdjustmentResult& adjusted, int camera,
                              int num_threads, CalibrationResult* result);

/// Adds to the rejected images those measured that are neither used nor held
/// out nor rejected already, and those skipped: each that was given is in one
/// of the lists.
void ListUnusedImages(const Dataset& measured,
                      const std::vector<RejectedImage>& skipped,
                      CalibrationResult* result);

/// Fills in how far the camera lies from a fleet's middle, where it has
/// features.
void FillFleetDistance(const CameraModel& middle, const LensSpread& spread,
                       CalibrationResult* result);

/// Figures of the held-out residuals, if there are any, what they show beyond
/// the camera's modes, and the verdict.
void AssessResult(int num_threads, CalibrationResult* result);

/// Whether there is more than noise in the errors, and so much that a verdict
/// will say it.
bool HasSystematicErrors(const CalibrationResult& result);

/// Whether neighbours err alike neither in images that the camera is adjusted
/// to nor in those held out: no camera fits the images of two.
bool IsSingleCamera(const CalibrationResult& result);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_RESULT_H
