#include "calibration/camera_adjustment.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <set>

#include "adjustment/metric_scale.h"
#include "camera/central_generic.h"
#include "camera/opencv.h"
#include "dataset/error.h"
#include "evaluation/residual_statistics.h"
#include "initialization/parametric_start.h"

namespace raygrid {
namespace {

constexpr int kMinImages = 3;
constexpr double kMaxStartErrorPart = 0.05;  // of the image's width

double RmsOf(const std::vector<Residual>& residuals) {
  double sum = 0;
  int count = 0;
  for (const Residual& residual : residuals) {
    if (!residual.valid) continue;
    sum += residual.error_px.squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : INFINITY;
}

// Poses of all views with the starting camera; views without one are removed.
AdjustmentState StartingState(const CameraModel& start, int num_threads,
                              CalibrationProblem* problem,
                              std::vector<RejectedImage>* rejected) {
  AdjustmentState state;
  state.SetCamera(start);
  state.points = problem->nominal;
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(start, 0, *problem, num_threads);
  std::vector<Pose> kept;
  std::vector<bool> remove(poses.size(), true);
  for (size_t v = 0; v < poses.size(); ++v) {
    if (poses[v]) {
      AdjustmentState alone = state;
      alone.rig_from_pattern = {*poses[v]};
      View view = problem->views[v];
      view.pose = 0;
      remove[v] = !(RmsOf(ComputeResiduals(alone, {view}, 1)) <
                    kMaxStartErrorPart * problem->image_sizes[0].width);
    }
    if (remove[v])
      rejected->push_back(
          {problem->images[v], "no pose explains its features"});
    else
      kept.push_back(*poses[v]);
  }
  RemoveViews(remove, problem);
  // In the order of the views, each of which has its own.
  state.rig_from_pattern = kept;
  return state;
}

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

AdjustmentSummary AdjustParametric(const CalibrationProblem& problem,
                                   const AdjustmentOptions& options,
                                   AdjustmentState* state) {
  GaussianPrior prior;
  prior.cameras = {
      DistortionPrior(dynamic_cast<const OpenCvModel&>(state->camera()),
                      FeatureArea(problem, 0))};
  return AdjustInTwoSteps(problem, options, &prior, state);
}

// The grid camera, around a parametric lens.
AdjustmentSummary AdjustGrid(const CalibrationProblem& problem,
                             const CameraModel& lens, double cell_px,
                             const AdjustmentOptions& options,
                             AdjustmentState* state) {
  const Area area = FeatureArea(problem, 0);
  const CentralGeneric base =
      FitCentralGeneric(lens, area, NumControlPoints(area.width(), cell_px),
                        NumControlPoints(area.height(), cell_px));
  GaussianPrior prior;
  prior.cameras = {SmoothnessPrior(base)};
  state->cameras[0] = base.Clone();
  return AdjustInTwoSteps(problem, options, &prior, state);
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

// A lens beyond the parametric model shows in features that it gives no
// direction to, or whose points it does not project.
constexpr double kMaxUnexplainedPart = 0.05;
void RequireParametricLens(const Adjusted& adjusted) {
  size_t index = 0, unexplained = 0;
  for (const View& view : adjusted.problem.views)
    for (const Observation& observation : view.observations)
      unexplained += !adjusted.summary.residuals[index++].valid ||
                     !adjusted.state.camera().Unproject(observation.pixel);
  if (static_cast<double>(unexplained) >
      kMaxUnexplainedPart * static_cast<double>(index))
    throw Error(
        ExitCode::kInitialization,
        fmt::format("the starting lens explains only {} of {} features; this "
                    "version starts from pinhole-like lenses, up to about 120 "
                    "degrees of view",
                    index - unexplained, index));
}

}  // namespace

Adjusted AdjustStart(const Dataset& dataset, const Pattern& pattern,
                     const AdjustmentOptions& options) {
  Adjusted adjusted;
  adjusted.problem =
      BuildProblem({dataset}, pattern, &adjusted.rejected_images);
  const auto require_images = [&adjusted] {
    const std::set<std::string> images(adjusted.problem.images.begin(),
                                       adjusted.problem.images.end());
    if (static_cast<int>(images.size()) < kMinImages)
      throw Error(ExitCode::kTooFew,
                  fmt::format("only {} images with {} features or more of one "
                              "board; at least {} are needed, {} are better",
                              images.size(), kMinViewFeatures, kMinImages, 20));
  };
  require_images();
  const auto start = StartFromPlanarBoards(dataset, pattern);
  if (!start)
    throw Error(ExitCode::kInitialization,
                "no starting camera fits these features; check the pattern's "
                "columns and rows, and take tilted views of it");
  adjusted.state = StartingState(*start, options.num_threads, &adjusted.problem,
                                 &adjusted.rejected_images);
  require_images();
  adjusted.summary = AdjustParametric(
      adjusted.problem, WithFixedPoints(options), &adjusted.state);
  RequireParametricLens(adjusted);
  return adjusted;
}

void AdjustModel(const Pattern& pattern, const std::string& model,
                 double cell_px, const AdjustmentOptions& options,
                 Adjusted* adjusted) {
  const std::unique_ptr<CameraModel> lens = adjusted->state.camera().Clone();
  const auto adjust = [&] {
    adjusted->summary =
        model == "opencv"
            ? AdjustParametric(adjusted->problem, options, &adjusted->state)
            : AdjustGrid(adjusted->problem, *lens, cell_px, options,
                         &adjusted->state);
  };
  adjust();
  adjusted->rejected_features =
      RemoveOutliers(pattern, adjusted->summary.residuals, &adjusted->problem);
  if (!adjusted->rejected_features.empty()) adjust();
  const Area area = FeatureArea(adjusted->problem, 0);
  if (const auto* camera =
          dynamic_cast<const OpenCvModel*>(&adjusted->state.camera()))
    adjusted->state.cameras[0] = camera->WithArea(area).Clone();
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
