#include "calibration/camera_in_progress.h"

#include <map>

#include "dataset/parallel_for.h"

namespace raygrid {

Dataset AllFeatures(const CameraInProgress& camera, const Pattern& pattern) {
  Dataset all = camera.input->dataset;
  if (camera.checkpoint.measured_again) {
    std::map<std::string, const ImageFeatures*> again;
    for (const ImageFeatures& image : camera.checkpoint.measured_again->images)
      again[image.image] = &image;
    for (ImageFeatures& image : all.images)
      if (const auto found = again.find(image.image); found != again.end())
        image = *found->second;
  }
  return Turned(all, pattern, camera.turns);
}

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
