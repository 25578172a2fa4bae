#ifndef RAYGRID_CALIBRATION_CAMERA_RESULT_H
#define RAYGRID_CALIBRATION_CAMERA_RESULT_H

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// Computes the residuals of a camera's training features.
std::vector<FeatureResidual> ComputeTrainingResiduals(
    const Pattern& pattern, const AdjustmentResult& adjusted, int camera,
    int num_threads);

/// Fills in the adjusted camera, with the image circle if known, and the
/// metrics of its training features.
void FillResult(const Pattern& pattern, const AdjustmentResult& adjusted,
                int camera, const std::optional<ImageCircle>& image_circle,
                int num_threads, CalibrationResult* result);

/// Replaces the camera of a result by the known one, and keeps its name and
/// training errors.
void KeepKnownCamera(const CameraFile& known, CalibrationResult* result);

/// Fills in the predicted uncertainty, the valid region and the extrapolated
/// region (EstimateUncertainty()). Requires the results of FillResult() and
/// does not change them.
void FillUncertainty(const AdjustmentResult& adjusted, int camera,
                     const std::optional<ImageCircle>& image_circle,
                     const std::optional<double>& valid_limit_px,
                     int num_threads, CalibrationResult* result);

/// Lists images with large held-out errors that alone cover some region of the
/// image: their training errors are no larger than the errors of other images,
/// and their held-out errors are within the predicted uncertainty.
void FindUniqueCoverageImages(const AdjustmentResult& adjusted, int camera,
                              int num_threads, CalibrationResult* result);

/// Adds to the rejected images the skipped images and all detected images that
/// are neither used, held out nor rejected, so that each input image is in one
/// of the lists.
void ListUnusedImages(const Dataset& measured,
                      const std::vector<RejectedImage>& skipped,
                      CalibrationResult* result);

/// Fills in the distance of the camera from a fleet's population mean, over the
/// area with features.
void FillFleetDistance(const CameraModel& mean,
                       const PopulationCovariance& spread,
                       CalibrationResult* result);

/// Fills in the metrics of held-out residuals, if any, their errors in excess
/// of the camera's uncertainty modes, and the assessment.
void AssessResult(int num_threads, CalibrationResult* result);

/// Returns whether the errors exceed noise enough for a warning.
bool HasSystematicErrors(const CalibrationResult& result);

/// Returns whether residuals are uncorrelated in both training and held-out
/// images, which excludes images of two cameras.
bool IsSingleCamera(const CalibrationResult& result);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_RESULT_H
