#include "calibration/measuring_again.h"

#include <algorithm>
#include <cmath>

#include "calibration/grid_choice.h"
#include "calibration/same_views.h"
#include "dataset/parallel_for.h"

namespace raygrid {

FirstCamera AdjustFirstCamera(const Pattern& pattern,
                              const CalibrationOptions& options,
                              const CameraInProgress& camera) {
  const double cell_px = options.cell_px > 0
                             ? options.cell_px
                             : MediumCellPx(camera.dataset, options.model);
  FirstCamera first = {camera.lens, {}};
  AdjustModel(pattern, options.model, {cell_px}, StoppableAdjustment(options),
              &first.adjusted);
  if (options.ShouldStop()) return first;
  AlignBoards(pattern, &first.adjusted);
  first.pattern = AdjustedPattern(pattern, first.adjusted);
  return first;
}

std::vector<BoardPose> LocalizedBoards(const CameraModel& camera,
                                       const Dataset& dataset,
                                       const Pattern& pattern,
                                       int num_threads) {
  std::vector<RejectedImage> rejected;
  const CalibrationProblem problem =
      BuildProblem({dataset}, pattern, &rejected);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(camera, 0, problem, num_threads);
  std::vector<BoardPose> known;
  for (size_t v = 0; v < poses.size(); ++v)
    if (poses[v])
      known.push_back(
          {problem.images[v], pattern.boards[problem.boards[v]].id, *poses[v]});
  return known;
}

std::optional<Dataset> MeasureFeaturesAgain(const Pattern& pattern,
                                            const CalibrationOptions& options,
                                            const CameraInProgress& camera) {
  const FirstCamera first = AdjustFirstCamera(pattern, options, camera);
  if (options.ShouldStop()) return std::nullopt;
  const CameraModel& model = first.adjusted.state.camera();
  Dataset again = camera.input->measure_again(
      model, first.pattern,
      LocalizedBoards(model, camera.dataset, first.pattern,
                      NumThreads(options.num_threads)));
  if (options.ShouldStop()) return std::nullopt;  // it may not be complete
  return WithoutOthers(again, camera.result.same_views);
}

double RmsMovePx(const Dataset& before, const Dataset& after) {
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < before.images.size(); ++i) {
    const auto& b = before.images[i].features;
    const auto& a = after.images[i].features;
    for (size_t k = 0; k < b.size(); ++k, ++count)
      sum += (a[k].pixel - b[k].pixel).squaredNorm();
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

}  // namespace raygrid
