#include "calibration/model_adjustment.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "adjustment/metric_scale.h"
#include "calibration/continued_lens.h"
#include "camera/model_fitting.h"
#include "camera/noncentral_generic.h"
#include "evaluation/line_spread.h"
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

// How far off axis a lens may be believed: a little beyond the points seen.
double CredibleAngle(const CalibrationProblem& problem,
                     const AdjustmentState& state) {
  constexpr double kBeyond = 1.05, kAlways = 60 * M_PI / 180;
  double farthest = 0;
  for (const View& view : problem.views) {
    const Pose pose = state.CameraFromPattern(view);
    for (const Observation& observation : view.observations) {
      const Eigen::Vector3d point = pose * state.points[observation.point];
      farthest =
          std::max(farthest, std::atan2(point.head<2>().norm(), point.z()));
    }
  }
  return std::max(kBeyond * farthest, kAlways);
}

CentralGeneric AsGrid(const CalibrationProblem& problem,
                      const AdjustmentState& state, const CameraModel& lens,
                      double cell_px) {
  const Area area = FeatureArea(problem, 0);
  return FitCentralGeneric(
      ContinuedLens(lens, area, CredibleAngle(problem, state)), area,
      NumControlPoints(area.width(), cell_px),
      NumControlPoints(area.height(), cell_px));
}

// The grid camera, around a parametric lens.
AdjustmentSummary AdjustGrid(const CalibrationProblem& problem,
                             const CameraModel& lens, double cell_px,
                             const AdjustmentOptions& options,
                             AdjustmentState* state) {
  const CentralGeneric base = AsGrid(problem, *state, lens, cell_px);
  GaussianPrior prior;
  prior.cameras = {SmoothnessPrior(base)};
  state->cameras[0] = base.Clone();
  return AdjustInTwoSteps(problem, options, &prior, state);
}

// Of the points seen, in front of the camera.
double MeanDistance(const CalibrationProblem& problem,
                    const AdjustmentState& state) {
  double sum = 0;
  int count = 0;
  for (const View& view : problem.views) {
    const Pose pose = state.CameraFromPattern(view);
    for (const Observation& observation : view.observations) {
      sum += (pose * state.points[observation.point]).norm();
      ++count;
    }
  }
  return sum / count;
}

// Lines, which start from an adjusted central grid. Its points stay where they
// are nominally: free, they would take on what is not central.
AdjustmentSummary AdjustLines(const CalibrationProblem& problem,
                              const CameraModel& lens, double cell_px,
                              const AdjustmentOptions& options,
                              AdjustmentState* state) {
  AdjustGrid(problem, lens, cell_px, WithFixedPoints(options), state);
  GaussianPrior prior;
  prior.cameras = {NonCentralPrior(AsGrid(problem, *state, lens, cell_px),
                                   MeanDistance(problem, *state))};
  state->cameras[0] =
      NonCentralGeneric(dynamic_cast<const CentralGeneric&>(state->camera()))
          .Clone();
  return AdjustInTwoSteps(problem, options, &prior, state);
}

AdjustmentSummary Adjust(const std::string& model,
                         const CalibrationProblem& problem,
                         const CameraModel& lens, double cell_px,
                         const AdjustmentOptions& options,
                         AdjustmentState* state) {
  if (IsParametricModel(model)) {
    state->cameras[0] = lens.Clone();
    if (lens.Name() != model)
      state->cameras[0] =
          FitParametricModel(model, lens, FeatureArea(problem, 0), false).model;
    return AdjustParametric(problem, options, state);
  }
  if (model == "noncentral-generic")
    return AdjustLines(problem, lens, cell_px, options, state);
  return AdjustGrid(problem, lens, cell_px, options, state);
}

// The frame of a camera whose lines do not meet has its origin at the point
// nearest to all of them; observations cannot tell.
void CenterLines(AdjustmentState* state) {
  const auto* camera = dynamic_cast<const NonCentralGeneric*>(&state->camera());
  if (!camera) return;
  const Eigen::Vector3d origin = MeasureLineSpread(*camera).nearest_point;
  state->cameras[0] = camera->WithOrigin(origin).Clone();
  for (Pose& pose : state->rig_from_pattern) pose.translation -= origin;
}

// Residuals beyond the third quartile + 6 interquartile ranges (paper's
// supplement, "Bundle adjustment details") leave the problem.
std::vector<FeatureResidual> RemoveOutliers(
    const Pattern& pattern, const std::vector<Residual>& residuals,
    CalibrationProblem* problem) {
  std::vector<double> norms;
  for (const Residual& residual : residuals)
    if (residual.valid) norms.push_back(residual.error_px.norm());
  const double q1 = Quantile(norms, 0.25), q3 = Quantile(norms, 0.75);
  const double threshold = q3 + 6 * (q3 - q1);
  std::vector<FeatureResidual> removed;
  size_t index = 0;
  for (size_t v = 0; v < problem->views.size(); ++v) {
    std::vector<Observation> kept;
    for (const Observation& observation : problem->views[v].observations) {
      const Residual& residual = residuals[index++];
      if (residual.valid && residual.error_px.norm() <= threshold) {
        kept.push_back(observation);
        continue;
      }
      const Feature feature =
          problem->FeatureOf(pattern, static_cast<int>(v), observation);
      removed.push_back({problem->images[v], feature.board, feature.column,
                         feature.row, observation.pixel, residual.error_px});
    }
    problem->views[v].observations = std::move(kept);
  }
  return removed;
}

}  // namespace

AdjustmentSummary AdjustParametric(const CalibrationProblem& problem,
                                   const AdjustmentOptions& options,
                                   AdjustmentState* state) {
  GaussianPrior prior;
  prior.cameras = {
      DistortionPrior(dynamic_cast<const ParametricModel&>(state->camera()),
                      FeatureArea(problem, 0))};
  return AdjustInTwoSteps(problem, options, &prior, state);
}

void AdjustModel(const Pattern& pattern, const std::string& model,
                 double cell_px, const AdjustmentOptions& options,
                 Adjusted* adjusted) {
  const std::unique_ptr<CameraModel> lens = adjusted->state.camera().Clone();
  const auto adjust = [&] {
    adjusted->summary = Adjust(model, adjusted->problem, *lens, cell_px,
                               options, &adjusted->state);
  };
  adjust();
  const std::vector<FeatureResidual> removed =
      RemoveOutliers(pattern, adjusted->summary.residuals, &adjusted->problem);
  adjusted->rejected_features.insert(adjusted->rejected_features.end(),
                                     removed.begin(), removed.end());
  if (!removed.empty()) adjust();
  const Area area = FeatureArea(adjusted->problem, 0);
  if (const auto* camera =
          dynamic_cast<const ParametricModel*>(&adjusted->state.camera()))
    adjusted->state.cameras[0] = camera->OverArea(area);
  CenterLines(&adjusted->state);
}

void AlignBoards(const Pattern& pattern, Adjusted* adjusted) {
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    std::set<int> poses;
    for (size_t v = 0; v < adjusted->problem.views.size(); ++v)
      if (adjusted->problem.boards[v] == static_cast<int>(b))
        poses.insert(adjusted->problem.views[v].pose);
    if (!poses.empty())
      AlignToNominal(adjusted->problem.first_points[b],
                     pattern.boards[b].points, {poses.begin(), poses.end()},
                     &adjusted->state);
  }
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
