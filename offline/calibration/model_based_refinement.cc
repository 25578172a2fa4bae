#include "calibration/model_based_refinement.h"

#include <algorithm>
#include <cmath>

#include "calibration/knot_spacing_selection.h"
#include "calibration/near_duplicates.h"
#include "dataset/parallel_for.h"

namespace raygrid {

FirstCamera EstimateFirstCamera(const Pattern& pattern,
                                const CalibrationOptions& options,
                                const CameraInProgress& camera) {
  const std::string model =
      camera.HasKnownIntrinsics() ? kModelOfKnownCameras : options.model;
  const double knot_spacing_px =
      options.knot_spacing_px > 0 ? options.knot_spacing_px
                                  : MediumKnotSpacingPx(camera.dataset, model);
  FirstCamera first = {camera.lens, {}};
  OptimizeModel(pattern, model, {knot_spacing_px},
                MakeStoppableOptions(options), &first.adjusted);
  if (options.ShouldStop()) return first;
  AlignBoards(pattern, &first.adjusted);
  first.pattern = MakeEstimatedPattern(pattern, first.adjusted);
  return first;
}

std::vector<BoardPose> LocalizeAllBoards(const CameraModel& camera,
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

std::optional<Dataset> RefineFeaturesWithModel(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera) {
  const FirstCamera first = EstimateFirstCamera(pattern, options, camera);
  if (options.ShouldStop()) return std::nullopt;
  const CameraModel& model = first.adjusted.state.camera();
  Dataset again = camera.input->refine_features(
      model, first.pattern,
      LocalizeAllBoards(model, camera.dataset, first.pattern,
                        NumThreads(options.num_threads)));
  if (options.ShouldStop()) return std::nullopt;  // possibly incomplete
  return RemoveDuplicates(again, camera.result.near_duplicates);
}

double ComputeRmsShiftPx(const Dataset& before, const Dataset& after) {
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
