#include "calibration/starting_camera.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "dataset/error.h"
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
  AdjustmentOptions fixed_points = options;
  fixed_points.fix_points = true;
  adjusted.summary =
      AdjustParametric(adjusted.problem, fixed_points, &adjusted.state);
  RequireParametricLens(adjusted);
  return adjusted;
}

}  // namespace raygrid
