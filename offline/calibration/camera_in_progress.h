#ifndef RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H
#define RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H

#include "calibration/board_rotations.h"
#include "calibration/calibration.h"
#include "calibration/cross_validation.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// A camera that is being calibrated.
struct CameraInProgress {
  const CalibrationInput* input = nullptr;
  Dataset dataset;  ///< as given, without images of the same view
  /// The features of all images as if frames were read at once, if motion was
  /// taken out.
  std::optional<Dataset> still;
  BoardRotations turns;   ///< of boards, against the features as given
  Split split;            ///< features as measured last
  AdjustmentResult lens;  ///< parametric, by its own training images
  Folds folds;            ///< of its training images
  bool per_view_deformation = false;  ///< from image to image
  double grid_knot_spacing_px =
      0;                     ///< of the central grid, where "auto" tried one
  Checkpoint checkpoint;     ///< what is done so far
  CalibrationResult result;  ///< what is known so far

  void Save() const {
    if (input->keep) input->keep(checkpoint);
  }
};

/// The features of all images, those among them that others stand for, as they
/// were measured last, with boards turned.
Dataset CollectFeatures(const CameraInProgress& camera, const Pattern& pattern);

/// The options of adjustments that run to their end.
AdjustmentOptions MakeAdjustmentOptions(const CalibrationOptions& options);

/// The options of adjustments that end when the calibration is told to stop.
AdjustmentOptions MakeStoppableOptions(const CalibrationOptions& options);

/// The options of a cross-validation without progress.
ValidationOptions MakeValidationOptions(const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H
