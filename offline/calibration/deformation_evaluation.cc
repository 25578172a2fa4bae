#include "calibration/deformation_evaluation.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "adjustment/bundle_adjustment.h"

namespace raygrid {
namespace {

bool IsEven(const Feature& feature) {
  return (feature.column + feature.row) % 2 == 0;
}

// Selects the features at even or odd lattice positions.
Dataset SelectAlternateFeatures(const Dataset& dataset, bool is_even) {
  Dataset half;
  half.image_size = dataset.image_size;
  for (const ImageFeatures& image : dataset.images) {
    half.images.push_back({image.image, {}});
    std::copy_if(image.features.begin(), image.features.end(),
                 std::back_inserter(half.images.back().features),
                 [is_even](const Feature& feature) {
                   return IsEven(feature) == is_even;
                 });
  }
  return half;
}

std::vector<Dataset> SplitFeatures(const std::vector<Dataset>& datasets,
                                   bool is_even) {
  std::vector<Dataset> halves;
  for (const Dataset& dataset : datasets)
    halves.push_back(SelectAlternateFeatures(dataset, is_even));
  return halves;
}

// Maps each image and board of the first half to its pose, which is used for
// the second half.
using Places = std::map<std::pair<std::string, int>, int>;

Places CollectFeaturePositions(const CalibrationProblem& problem) {
  Places places;
  for (size_t v = 0; v < problem.views.size(); ++v)
    places[{problem.images[v], problem.boards[v]}] = problem.views[v].pose;
  return places;
}

}  // namespace

std::vector<std::vector<FeatureResidual>> EvaluateWithDeformation(
    const RigModel& rig, const std::vector<Dataset>& datasets,
    const Pattern& pattern, int num_threads) {
  std::vector<std::vector<FeatureResidual>> residuals(rig.cameras.size());
  std::vector<RejectedImage> rejected;
  CalibrationProblem determined =
      BuildProblem(SplitFeatures(datasets, true), pattern, &rejected);
  AdjustmentState state = LocalizeRigViews(rig, &determined, num_threads);
  state.SetModes(GetDeformationModes(determined), DeformationScope::kPose);
  if (determined.views.empty() || state.modes.count() == 0) return residuals;
  GaussianPrior prior;
  prior.points_mean = state.points;
  AdjustmentOptions options;
  options.fix_cameras = options.fix_points = true;
  options.num_threads = num_threads;
  OptimizeWithLearnedPrior(determined.views, options, &prior, &state);

  const Places places = CollectFeaturePositions(determined);
  const CalibrationProblem view_problem =
      BuildProblem(SplitFeatures(datasets, false), pattern, &rejected);
  for (size_t v = 0; v < view_problem.views.size(); ++v) {
    const auto place =
        places.find({view_problem.images[v], view_problem.boards[v]});
    if (place == places.end()) continue;
    View view = view_problem.views[v];
    view.pose = place->second;
    const std::vector<Residual> view_residuals =
        ComputeResiduals(state, {view}, 1);
    const Area& area = rig.cameras[view.camera]->area();
    for (size_t i = 0; i < view_residuals.size(); ++i) {
      const Observation& observation = view.observations[i];
      if (!view_residuals[i].valid || !area.Contains(observation.pixel))
        continue;
      const Feature feature =
          view_problem.GetFeature(pattern, static_cast<int>(v), observation);
      residuals[view.camera].push_back(
          {view_problem.images[v], feature.board, feature.column, feature.row,
           observation.pixel, view_residuals[i].error_px});
    }
  }
  return residuals;
}

}  // namespace raygrid
