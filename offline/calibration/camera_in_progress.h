#ifndef RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H
#define RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H

#include "calibration/board_turns.h"
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
  BoardTurns turns;          ///< of boards, against the features as given
  Split split;               ///< features as measured last
  Adjusted lens;             ///< parametric, by its own training images
  Folds folds;               ///< of its training images
  bool boards_bend = false;  ///< from image to image
  double grid_cell_px = 0;   ///< of the central grid, where "auto" tried one
  Checkpoint checkpoint;     ///< what is done so far
  CalibrationResult result;  ///< what is known so far

  void Keep() const {
    if (input->keep) input->keep(checkpoint);
  }
};

/// The features of all images, those among them that others stand for, as they
/// were measured last, with boards turned.
Dataset AllFeatures(const CameraInProgress& camera, const Pattern& pattern);

/// The options of adjustments that run to their end.
AdjustmentOptions AdjustmentOptionsOf(const CalibrationOptions& options);

/// The options of adjustments that end when the calibration is told to stop.
AdjustmentOptions StoppableAdjustment(const CalibrationOptions& options);

/// The options of a cross-validation without progress.
ValidationOptions ValidationOptionsOf(const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_IN_PROGRESS_H
