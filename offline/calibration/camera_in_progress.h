#ifndef RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H
#define RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H

#include "calibration/board_rotations.h"
#include "calibration/calibration.h"
#include "calibration/cross_validation.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// The model whose steps are run for cameras with known intrinsics.
constexpr const char* kModelOfKnownCameras = models::kOpenCv;

/// State of a camera during its calibration.
struct CameraInProgress {
  const CalibrationInput* input = nullptr;
  Dataset dataset;  ///< input without near-duplicates
  /// Features of all images with rolling shutter compensated; nullopt if it was
  /// not.
  std::optional<Dataset> still;
  BoardRotations turns;  ///< relative to the feature numbering of the input
  Split split;           ///< refined features, if any
  AdjustmentResult
      lens;     ///< parametric camera fitted to its own training images
  Folds folds;  ///< folds of its training images
  bool per_view_deformation = false;  ///< deformation may differ between images
  double grid_knot_spacing_px = 0;    ///< central grid tried by "auto"
  Checkpoint checkpoint;              ///< completed steps
  CalibrationResult result;           ///< results so far

  bool HasKnownIntrinsics() const { return input->intrinsics != nullptr; }
  void Save() const {
    if (input->keep) input->keep(checkpoint);
  }
};

/// Returns the latest features of all images, including near-duplicates, with
/// board rotations applied.
Dataset CollectFeatures(const CameraInProgress& camera, const Pattern& pattern);

/// Returns options of adjustments that run to completion.
AdjustmentOptions MakeAdjustmentOptions(const CalibrationOptions& options);

/// Returns options of adjustments that end when the calibration is stopped.
AdjustmentOptions MakeStoppableOptions(const CalibrationOptions& options);

/// Returns cross-validation options without progress reports.
ValidationOptions MakeValidationOptions(const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H
