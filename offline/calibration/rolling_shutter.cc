#include "calibration/rolling_shutter.h"

#include <set>
#include <string>
#include <vector>

#include "calibration/model_based_refinement.h"
#include "shutter/line_delay.h"

namespace raygrid {
namespace {

MovingViews MakeMovingViews(const CameraModel& camera, const Pattern& found,
                            const Dataset& features, const ImageTimes& times,
                            bool is_final, int num_threads) {
  return {&camera,   &found,
          &features, LocalizeAllBoards(camera, features, found, num_threads),
          &times,    is_final};
}

// Returns the images that lost all features in the rolling-shutter
// compensation.
std::set<std::string> ListExcludedImages(const Dataset& measured,
                                         const Dataset& still) {
  std::set<std::string> names;
  for (size_t i = 0; i < measured.images.size(); ++i)
    if (!measured.images[i].features.empty() &&
        still.images[i].features.empty())
      names.insert(measured.images[i].image);
  return names;
}

}  // namespace

std::optional<CompensatedFeatures> ComputeCompensatedFeatures(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera) {
  const FirstCamera first = EstimateFirstCamera(pattern, options, camera);
  if (options.ShouldStop()) return std::nullopt;
  const Dataset features = CollectFeatures(camera, pattern);
  const MovingViews views =
      MakeMovingViews(first.adjusted.state.camera(), first.pattern, features,
                      *camera.input->times, false, options.num_threads);
  const LineDelayEstimate line_delay = EstimateLineDelay(views);
  if (!line_delay.IsDetermined() || line_delay.value.IsPossiblyGlobalShutter())
    return std::nullopt;
  return CompensatedFeatures{
      line_delay.value,
      ComputeGlobalShutterFeatures(views, line_delay.value.seconds)};
}

LineDelayEstimate EstimateFinalLineDelay(const CameraInProgress& camera,
                                         const CameraModel& calibrated,
                                         const Pattern& found,
                                         int num_threads) {
  const Dataset features = CollectFeatures(camera, found);
  LineDelayEstimate line_delay = EstimateLineDelay(MakeMovingViews(
      calibrated, found, features, *camera.input->times, true, num_threads));
  line_delay.is_compensated = camera.still.has_value();
  if (camera.still)
    line_delay.num_left_out =
        static_cast<int>(ListExcludedImages(features, *camera.still).size());
  return line_delay;
}

void ReportExcludedImages(const CameraInProgress& camera,
                          const Pattern& pattern,
                          std::vector<RejectedImage>* rejected) {
  if (!camera.still) return;
  const std::set<std::string> left_out =
      ListExcludedImages(CollectFeatures(camera, pattern), *camera.still);
  for (RejectedImage& image : *rejected)
    if (left_out.count(image.image) > 0)
      image = {image.image,
               "unknown motion: no timestamp, no adjacent frames, or pose "
               "estimation failed"};
}

}  // namespace raygrid
