#include "calibration/camera_in_progress.h"

#include <map>

#include "dataset/parallel_for.h"

namespace raygrid {

Dataset CollectFeatures(const CameraInProgress& camera,
                        const Pattern& pattern) {
  Dataset all = camera.input->dataset;
  if (camera.checkpoint.refined_features) {
    std::map<std::string, const ImageFeatures*> again;
    for (const ImageFeatures& image :
         camera.checkpoint.refined_features->images)
      again[image.image] = &image;
    for (ImageFeatures& image : all.images)
      if (const auto found = again.find(image.image); found != again.end())
        image = *found->second;
  }
  return Rotated(all, pattern, camera.turns);
}

AdjustmentOptions MakeAdjustmentOptions(const CalibrationOptions& options) {
  AdjustmentOptions adjustment;
  adjustment.num_threads = NumThreads(options.num_threads);
  adjustment.fix_points = options.fix_target_geometry;
  return adjustment;
}

AdjustmentOptions MakeStoppableOptions(const CalibrationOptions& options) {
  AdjustmentOptions adjustment = MakeAdjustmentOptions(options);
  adjustment.should_stop = options.should_stop;
  return adjustment;
}

ValidationOptions MakeValidationOptions(const CalibrationOptions& options) {
  ValidationOptions validation;
  validation.model = options.model;
  validation.area = options.area;
  validation.like = options.like;
  validation.prior_population = options.prior_population;
  validation.fix_target_geometry = options.fix_target_geometry;
  validation.num_threads = options.num_threads;
  validation.should_stop = options.should_stop;
  return validation;
}

}  // namespace raygrid
