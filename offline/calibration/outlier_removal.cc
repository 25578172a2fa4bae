#include "calibration/outlier_removal.h"

#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Returns the outlier threshold of each camera.
std::vector<double> OutlierThresholds(const std::vector<Residual>& residuals,
                                      const CalibrationProblem& problem) {
  std::vector<std::vector<double>> norms(problem.image_sizes.size());
  size_t index = 0;
  for (const View& view : problem.views)
    for (size_t k = 0; k < view.observations.size(); ++k, ++index)
      if (residuals[index].valid)
        norms[view.camera].push_back(residuals[index].error_px.norm());
  std::vector<double> thresholds;
  for (const std::vector<double>& camera : norms) {
    const double q1 = Quantile(camera, 0.25), q3 = Quantile(camera, 0.75);
    thresholds.push_back(q3 + 6 * (q3 - q1));
  }
  return thresholds;
}

bool IsOutlier(const Residual& residual, double threshold) {
  return !residual.valid || residual.error_px.norm() > threshold;
}

// Removes residuals beyond the thresholds from the problem, and returns them by
// camera.
std::vector<std::vector<FeatureResidual>> RemoveOutlierResiduals(
    const Pattern& pattern, const std::vector<Residual>& residuals,
    CalibrationProblem* problem) {
  const std::vector<double> thresholds = OutlierThresholds(residuals, *problem);
  std::vector<std::vector<FeatureResidual>> removed(thresholds.size());
  size_t index = 0;
  for (size_t v = 0; v < problem->views.size(); ++v) {
    View& view = problem->views[v];
    std::vector<Observation> kept;
    for (const Observation& observation : view.observations) {
      const Residual& residual = residuals[index++];
      if (!IsOutlier(residual, thresholds[view.camera])) {
        kept.push_back(observation);
        continue;
      }
      const Feature feature =
          problem->GetFeature(pattern, static_cast<int>(v), observation);
      removed[view.camera].push_back({problem->images[v], feature.board,
                                      feature.column, feature.row,
                                      observation.pixel, residual.error_px});
    }
    view.observations = std::move(kept);
  }
  return removed;
}

std::vector<Area> ComputeCalibratedAreas(const CalibrationProblem& problem) {
  std::vector<Area> areas;
  for (size_t c = 0; c < problem.image_sizes.size(); ++c)
    areas.push_back(ComputeCalibratedArea(problem, static_cast<int>(c)));
  return areas;
}

}  // namespace

bool HasOutliers(const std::vector<Residual>& residuals,
                 const CalibrationProblem& problem) {
  const std::vector<double> thresholds = OutlierThresholds(residuals, problem);
  size_t index = 0;
  for (const View& view : problem.views)
    for (size_t k = 0; k < view.observations.size(); ++k, ++index)
      if (IsOutlier(residuals[index], thresholds[view.camera])) return true;
  return false;
}

RemovalResult RemoveOutliers(const Pattern& pattern,
                             AdjustmentResult* adjusted) {
  const std::vector<Area> areas = ComputeCalibratedAreas(adjusted->problem);
  const auto removed = RemoveOutlierResiduals(
      pattern, adjusted->summary.residuals, &adjusted->problem);
  bool have_removed = false;
  for (size_t c = 0; c < removed.size(); ++c) {
    auto& rejected = adjusted->rejected_features[c];
    rejected.insert(rejected.end(), removed[c].begin(), removed[c].end());
    have_removed = have_removed || !removed[c].empty();
  }
  if (!have_removed) return RemovalResult::kNone;
  return ComputeCalibratedAreas(adjusted->problem) == areas
             ? RemovalResult::kSome
             : RemovalResult::kPartOfArea;
}

}  // namespace raygrid
