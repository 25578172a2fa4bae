#include "calibration/camera_in_progress.h"

#include "dataset/parallel_for.h"

namespace raygrid {

AdjustmentOptions AdjustmentOptionsOf(const CalibrationOptions& options) {
  AdjustmentOptions adjustment;
  adjustment.num_threads = NumThreads(options.num_threads);
  adjustment.fix_points = options.flat_board;
  return adjustment;
}

AdjustmentOptions StoppableAdjustment(const CalibrationOptions& options) {
  AdjustmentOptions adjustment = AdjustmentOptionsOf(options);
  adjustment.should_stop = options.should_stop;
  return adjustment;
}

ValidationOptions ValidationOptionsOf(const CalibrationOptions& options) {
  ValidationOptions validation;
  validation.model = options.model;
  validation.area = options.area;
  validation.like = options.like;
  validation.like_spread = options.like_spread;
  validation.flat_board = options.flat_board;
  validation.num_threads = options.num_threads;
  validation.should_stop = options.should_stop;
  return validation;
}

}  // namespace raygrid
