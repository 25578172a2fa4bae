#include "calibration/model_adjustment.h"

#include <algorithm>
#include <memory>
#include <set>

#include "adjustment/metric_scale.h"
#include "camera/central_generic.h"
#include "camera/opencv.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// The pattern's points stay where they are nominally.
AdjustmentOptions WithFixedPoints(AdjustmentOptions options) {
  options.fix_points = true;
  return options;
}

// First with fixed points, a small problem from a rough start; then, if they
// may move, with all of them, from a good start.
AdjustmentSummary AdjustInTwoSteps(const CalibrationProblem& problem,
                                   const AdjustmentOptions& options,
                                   GaussianPrior* prior,
                                   AdjustmentState* state) {
  prior->points_mean = problem.nominal;
  AdjustmentSummary summary = AdjustWithLearnedPrior(
      problem.views, WithFixedPoints(options), prior, state);
  if (!options.fix_points)
    summary = AdjustWithLearnedPrior(problem.views, options, prior, state);
  return summary;
}

using Lenses = std::vector<std::unique_ptr<CameraModel>>;

// Grid cameras, each around a parametric lens.
AdjustmentSummary AdjustGrids(const CalibrationProblem& problem,
                              const Lenses& lenses,
                              const std::vector<double>& cells_px,
                              const AdjustmentOptions& options,
                              GaussianPrior* prior, AdjustmentState* state) {
  *prior = {};
  for (size_t c = 0; c < lenses.size(); ++c) {
    const Area area = FeatureArea(problem, static_cast<int>(c));
    const CentralGeneric base = FitCentralGeneric(
        *lenses[c], area, NumControlPoints(area.width(), cells_px[c]),
        NumControlPoints(area.height(), cells_px[c]));
    prior->cameras.push_back(SmoothnessPrior(base));
    state->cameras[c] = base.Clone();
  }
  return AdjustInTwoSteps(problem, options, prior, state);
}

// Parametric cameras from where the state is.
AdjustmentSummary AdjustLenses(const CalibrationProblem& problem,
                               const AdjustmentOptions& options,
                               GaussianPrior* prior, AdjustmentState* state) {
  *prior = {};
  for (size_t c = 0; c < state->cameras.size(); ++c)
    prior->cameras.push_back(
        DistortionPrior(dynamic_cast<const OpenCvModel&>(*state->cameras[c]),
                        FeatureArea(problem, static_cast<int>(c))));
  return AdjustInTwoSteps(problem, options, prior, state);
}

// Of each camera: the third quartile of the residuals + 6 interquartile ranges
// (paper's supplement, "Bundle adjustment details").
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

// Residuals beyond the thresholds leave the problem.
std::vector<std::vector<FeatureResidual>> RemoveOutliers(
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
      if (residual.valid &&
          residual.error_px.norm() <= thresholds[view.camera]) {
        kept.push_back(observation);
        continue;
      }
      const Feature feature =
          problem->FeatureOf(pattern, static_cast<int>(v), observation);
      removed[view.camera].push_back({problem->images[v], feature.board,
                                      feature.column, feature.row,
                                      observation.pixel, residual.error_px});
    }
    view.observations = std::move(kept);
  }
  return removed;
}

Lenses CopyCameras(const AdjustmentState& state) {
  Lenses cameras;
  for (const auto& camera : state.cameras) cameras.push_back(camera->Clone());
  return cameras;
}

}  // namespace

AdjustmentSummary AdjustParametric(const CalibrationProblem& problem,
                                   const AdjustmentOptions& options,
                                   AdjustmentState* state) {
  GaussianPrior prior;
  return AdjustLenses(problem, options, &prior, state);
}

void AdjustModel(const Pattern& pattern, const std::string& model,
                 const std::vector<double>& cells_px,
                 const AdjustmentOptions& options, Adjusted* adjusted) {
  const Lenses lenses = CopyCameras(adjusted->state);
  const auto adjust = [&] {
    adjusted->summary =
        model == "opencv"
            ? AdjustLenses(adjusted->problem, options, &adjusted->prior,
                           &adjusted->state)
            : AdjustGrids(adjusted->problem, lenses, cells_px, options,
                          &adjusted->prior, &adjusted->state);
  };
  adjust();
  adjusted->rejected_features =
      RemoveOutliers(pattern, adjusted->summary.residuals, &adjusted->problem);
  if (std::any_of(adjusted->rejected_features.begin(),
                  adjusted->rejected_features.end(),
                  [](const auto& removed) { return !removed.empty(); }))
    adjust();
  for (size_t c = 0; c < lenses.size(); ++c) {
    std::unique_ptr<CameraModel>& camera = adjusted->state.cameras[c];
    if (const auto* lens = dynamic_cast<const OpenCvModel*>(camera.get()))
      camera =
          lens->WithArea(FeatureArea(adjusted->problem, static_cast<int>(c)))
              .Clone();
  }
}

void AlignBoards(const Pattern& pattern, Adjusted* adjusted) {
  std::vector<AlignedBoard> boards;
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    std::set<int> poses;
    for (size_t v = 0; v < adjusted->problem.views.size(); ++v)
      if (adjusted->problem.boards[v] == static_cast<int>(b))
        poses.insert(adjusted->problem.views[v].pose);
    if (!poses.empty())
      boards.push_back({adjusted->problem.first_points[b],
                        pattern.boards[b].points,
                        {poses.begin(), poses.end()}});
  }
  AlignToNominal(boards, &adjusted->state);
}

Pattern AdjustedPattern(const Pattern& pattern, const Adjusted& adjusted) {
  Pattern result = pattern;
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    const auto first =
        adjusted.state.points.begin() + adjusted.problem.first_points[b];
    result.boards[b].points.assign(first,
                                   first + pattern.boards[b].num_points());
  }
  return result;
}

}  // namespace raygrid
