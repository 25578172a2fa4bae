#include "calibration/row_motion.h"

#include <set>
#include <string>
#include <vector>

#include "calibration/measuring_again.h"
#include "shutter/row_time.h"

namespace raygrid {
namespace {

MovingViews ViewsBy(const CameraModel& camera, const Pattern& found,
                    const Dataset& features, const ImageTimes& times,
                    bool is_final, int num_threads) {
  return {&camera,   &found,
          &features, LocalizedBoards(camera, features, found, num_threads),
          &times,    is_final};
}

// The images that lost all of their features with the motion.
std::set<std::string> ImagesLeftOut(const Dataset& measured,
                                    const Dataset& still) {
  std::set<std::string> names;
  for (size_t i = 0; i < measured.images.size(); ++i)
    if (!measured.images[i].features.empty() &&
        still.images[i].features.empty())
      names.insert(measured.images[i].image);
  return names;
}

}  // namespace

std::optional<StillFeatures> FeaturesWithoutRowMotion(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera) {
  const FirstCamera first = AdjustFirstCamera(pattern, options, camera);
  if (options.ShouldStop()) return std::nullopt;
  const Dataset features = AllFeatures(camera, pattern);
  const MovingViews views =
      ViewsBy(first.adjusted.state.camera(), first.pattern, features,
              *camera.input->times, false, options.num_threads);
  const RowTimeEstimate row_time = EstimateRowTime(views);
  if (!row_time.IsTold() || row_time.value.MayBeGlobal()) return std::nullopt;
  return StillFeatures{row_time.value,
                       WithoutRowMotion(views, row_time.value.seconds)};
}

RowTimeEstimate RowTimeOf(const CameraInProgress& camera,
                          const CameraModel& calibrated, const Pattern& found,
                          int num_threads) {
  const Dataset features = AllFeatures(camera, found);
  RowTimeEstimate row_time = EstimateRowTime(ViewsBy(
      calibrated, found, features, *camera.input->times, true, num_threads));
  row_time.is_taken_out = camera.still.has_value();
  if (camera.still)
    row_time.num_left_out =
        static_cast<int>(ImagesLeftOut(features, *camera.still).size());
  return row_time;
}

void NameImagesLeftOut(const CameraInProgress& camera, const Pattern& pattern,
                       std::vector<RejectedImage>* rejected) {
  if (!camera.still) return;
  const std::set<std::string> left_out =
      ImagesLeftOut(AllFeatures(camera, pattern), *camera.still);
  for (RejectedImage& image : *rejected)
    if (left_out.count(image.image) > 0)
      image = {image.image,
               "unknown motion: no timestamp, no adjacent frames, or pose "
               "estimation failed"};
}

}  // namespace raygrid
