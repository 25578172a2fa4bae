#include "calibration/model_adjustment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "adjustment/metric_scale.h"
#include "adjustment/smoothness_prior.h"
#include "calibration/base_model.h"
#include "calibration/camera_adjustment.h"
#include "calibration/divergence.h"
#include "calibration/outlier_removal.h"
#include "calibration/unobserved_control_points.h"
#include "camera/fixed_camera.h"
#include "camera/model_registry.h"
#include "camera/noncentral_generic.h"
#include "evaluation/board_flatness.h"
#include "evaluation/noncentrality.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Moves the origin of each non-central camera, which is not observable, to the
// point closest to all observation lines.
void CenterLines(AdjustmentState* state) {
  bool have_moved = false;
  for (size_t c = 0; c < state->cameras.size(); ++c) {
    const auto* camera =
        dynamic_cast<const NonCentralGeneric*>(state->cameras[c].get());
    if (!camera) continue;
    const Eigen::Vector3d origin = ComputeNoncentrality(*camera).nearest_point;
    state->cameras[c] = camera->WithOrigin(origin).Clone();
    state->camera_from_rig[c].translation -= origin;
    have_moved = true;
  }
  if (have_moved) state->MoveRigToFirstCamera();
}

// Estimates static deformation, which may become observable once outliers are
// removed.
void EstimateStaticDeformation(AdjustmentResult* adjusted) {
  AdjustmentState& state = adjusted->state;
  state.ApplyStaticDeformation();
  state.FitStaticDeformation(GetDeformationModes(adjusted->problem),
                             adjusted->problem.nominal);
}

void ContinueOptimization(const AdjustmentOptions& options,
                          AdjustmentResult* adjusted) {
  adjusted->summary = OptimizeWithLearnedPrior(
      adjusted->problem.views, options, &adjusted->prior, &adjusted->state);
}

// Initializes grids with the base models as prior mean and a prior precision
// according to the residuals.
void InitializeGrids(const std::string& model, const InitialValues& starts,
                     const AdjustmentOptions& options,
                     AdjustmentResult* adjusted) {
  const CalibrationProblem& problem = adjusted->problem;
  adjusted->prior = {};
  adjusted->prior.points_mean = problem.nominal;
  for (size_t c = 0; c < starts.lenses.size(); ++c) {
    if (IsFixed(*starts.lenses[c])) {
      adjusted->prior.cameras.emplace_back();
      continue;
    }
    const CentralGeneric grid = MakeInitialGrid(problem, c, starts);
    const std::vector<Eigen::Vector2d> observed_px =
        ObservedPixels(problem, static_cast<int>(c));
    if (model == models::kNonCentralGeneric) {
      adjusted->state.cameras[c] = NonCentralGeneric(grid).Clone();
      adjusted->prior.cameras.push_back(MakeNonCentralPrior(
          grid, observed_px, ComputeMeanDistance(problem, c, adjusted->state)));
    } else {
      adjusted->state.cameras[c] = grid.Clone();
      adjusted->prior.cameras.push_back(MakeSmoothnessPrior(grid, observed_px));
    }
  }
  adjusted->summary = {};
  adjusted->summary.residuals =
      ComputeResiduals(adjusted->state, problem.views, options.num_threads);
  const double variance =
      ResidualVariance(adjusted->summary.residuals, options.huber_px, 0);
  adjusted->summary.noise_px = std::sqrt(variance);
  for (CameraPrior& prior : adjusted->prior.cameras)
    for (PriorGroup& group : prior.groups) group.SetPrecision(1, variance);
}

// Returns options that end an optimization early if there are outliers, which
// are then removed.
AdjustmentOptions StopAtOutliers(AdjustmentOptions options,
                                 const AdjustmentResult& adjusted) {
  options.should_accept = [&adjusted](const std::vector<Residual>& residuals) {
    return HasOutliers(residuals, adjusted.problem);
  };
  return options;
}

bool AreSamePoints(const std::vector<View>& a, const std::vector<View>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const View& first, const View& second) {
                      return std::equal(
                          first.observations.begin(), first.observations.end(),
                          second.observations.begin(),
                          second.observations.end(),
                          [](const Observation& x, const Observation& y) {
                            return x.point == y.point;
                          });
                    });
}

// Performs the steps of OptimizeWithRigidBoards() from a warm start. Its
// outliers are removed at first, and determined again from the new result.
void AdjustFromWarmStart(const Pattern& pattern, const std::string& model,
                         const std::vector<double>& knot_spacings_px,
                         const AdjustmentOptions& options,
                         const AdjustmentResult& warm,
                         AdjustmentResult* adjusted) {
  AdjustmentOptions brief = options;
  brief.max_iterations = 0;  // cross-validation does not need the last digits
  CalibrationProblem& problem = adjusted->problem;
  std::vector<View> all = problem.views;
  problem.views = warm.problem.views;
  const CameraModels lenses = CopyCameras(adjusted->state);
  adjusted->summary = OptimizeCameras(
      model, problem, {lenses, knot_spacings_px, adjusted->base_models, &warm},
      brief, &adjusted->prior, &adjusted->state);
  std::vector<View> kept = std::exchange(problem.views, std::move(all));
  std::vector<Residual> kept_residuals = std::exchange(
      adjusted->summary.residuals,
      ComputeResiduals(adjusted->state, problem.views, options.num_threads));
  RemoveOutliers(pattern, adjusted);
  if (AreSamePoints(problem.views, kept))
    adjusted->summary.residuals = std::move(kept_residuals);
  else
    ContinueOptimization(brief, adjusted);
}

// Performs the steps of OptimizeWithRigidBoards() from the current state.
void AdjustFromModels(const Pattern& pattern, const std::string& model,
                      const std::vector<double>& knot_spacings_px,
                      const AdjustmentOptions& options,
                      AdjustmentResult* adjusted) {
  CameraModels lenses = CopyCameras(adjusted->state);
  const AdjustmentState start = adjusted->state;
  const auto adjust = [&](const AdjustmentOptions& with) {
    adjusted->summary =
        OptimizeCameras(model, adjusted->problem,
                        {lenses, knot_spacings_px, adjusted->base_models}, with,
                        &adjusted->prior, &adjusted->state);
  };
  // Stops the first stage early if there are outliers, which are then removed.
  adjust(IsParametricModel(model) ? options
                                  : StopAtOutliers(options, *adjusted));
  switch (RemoveOutliers(pattern, adjusted)) {
    case RemovalResult::kNone:
      break;
    case RemovalResult::kSome:
      if (!options.fix_points) EstimateStaticDeformation(adjusted);
      ContinueOptimization(options, adjusted);
      break;
    case RemovalResult::kPartOfArea:
      // Initial cameras without an optical axis may have been rotated by
      // SetLens().
      if (!AreParametric(lenses)) adjusted->state = start;
      if (!IsParametricModel(model)) {
        for (size_t c = 0; c < lenses.size(); ++c)
          adjusted->state.cameras[c] = lenses[c]->Clone();
        FitBaseModels(options, adjusted);
        lenses = CopyCameras(adjusted->state);
      }
      adjust(options);
      break;
  }
}

// Adjusts from initial cameras of other models if the given one diverges. If
// all of them diverge, a grid fitted to the given one is returned, marked as
// not converged, provided it has the smallest error.
void AdjustFromOtherModels(const Pattern& pattern, const std::string& model,
                           const std::vector<double>& knot_spacings_px,
                           const AdjustmentOptions& options,
                           const AdjustmentResult& start,
                           AdjustmentResult* adjusted) {
  double min_error_px = ComputeMeanErrorPx(*adjusted, start);
  for (const std::string& other : ListModelNames(ModelUse::kCompare)) {
    if (options.should_stop && options.should_stop()) break;
    AdjustmentResult from = start;
    from.base_models.clear();
    OptimizeParametricCameras(other, from.problem, CopyCameras(start.state),
                              MakeInitializationOptions(options), &from.prior,
                              &from.state);
    if (HasDiverged(from, start)) continue;
    AdjustFromModels(pattern, model, knot_spacings_px, options, &from);
    const double error_px = ComputeMeanErrorPx(from, start);
    if (error_px >= min_error_px) continue;
    min_error_px = error_px;
    *adjusted = std::move(from);
  }
  if (IsParametricModel(model) || !HasDiverged(*adjusted, start)) return;
  // If the knot spacing is too coarse for the lens, the initial grid is no
  // better.
  AdjustmentResult around = start;
  InitializeGrids(model, {CopyCameras(start.state), knot_spacings_px, {}},
                  options, &around);
  if (ComputeMeanErrorPx(around, start) < min_error_px)
    *adjusted = std::move(around);
}

bool HasSameViews(const CalibrationProblem& a, const CalibrationProblem& b) {
  return a.images == b.images && a.boards == b.boards && a.area == b.area &&
         a.area == AreaChoice::kWholeImage;
}

// Whether divergence can be assessed: only if the initial cameras had the same
// model, since other models may fit the lens better than this one can.
bool CanAssessDivergence(const AdjustmentState& start,
                         const std::string& model) {
  return !IsParametricModel(model) ||
         std::all_of(
             start.cameras.begin(), start.cameras.end(),
             [&](const auto& camera) { return camera->Name() == model; });
}

}  // namespace

void OptimizeWithRigidBoards(const Pattern& pattern, const std::string& model,
                             const std::vector<double>& knot_spacings_px,
                             const AdjustmentOptions& options,
                             AdjustmentResult* adjusted,
                             const AdjustmentResult* warm) {
  const AdjustmentResult start = *adjusted;
  const bool can_assess = CanAssessDivergence(start.state, model);
  if (warm && HasSameViews(warm->problem, start.problem)) {
    AdjustFromWarmStart(pattern, model, knot_spacings_px, options, *warm,
                        adjusted);
    if (!HasDiverged(*adjusted, can_assess ? start : *warm)) return;
    *adjusted = start;
  }
  AdjustFromModels(pattern, model, knot_spacings_px, options, adjusted);
  if (can_assess && HasDiverged(*adjusted, start))
    AdjustFromOtherModels(pattern, model, knot_spacings_px, options, start,
                          adjusted);
}

AdjustmentResult RemoveViewsAndPoses(const std::vector<bool>& remove,
                                     const AdjustmentResult& adjusted) {
  AdjustmentResult part = adjusted;
  std::vector<Pose> kept;
  for (size_t v = 0; v < remove.size(); ++v)
    if (!remove[v])
      kept.push_back(
          adjusted.state.rig_from_pattern[adjusted.problem.views[v].pose]);
  RemoveViews(remove, &part.problem);
  part.state.rig_from_pattern = std::move(kept);
  const std::set<std::string> images(part.problem.images.begin(),
                                     part.problem.images.end());
  for (std::vector<FeatureResidual>& rejected : part.rejected_features)
    rejected.erase(std::remove_if(rejected.begin(), rejected.end(),
                                  [&images](const FeatureResidual& feature) {
                                    return images.count(feature.image) == 0;
                                  }),
                   rejected.end());
  return part;
}

void EstimateDeformation(const Pattern& pattern,
                         const AdjustmentOptions& options,
                         AdjustmentResult* adjusted) {
  AdjustmentState& state = adjusted->state;
  const std::vector<Eigen::Vector3d> points = state.points;
  state.ApplyStaticDeformation();
  for (size_t i = 0; i < points.size(); ++i)
    adjusted->prior.points_mean[i] += state.points[i] - points[i];
  state.SetModes(GetDeformationModes(adjusted->problem),
                 DeformationScope::kPose);
  adjusted->prior.deformation_precisions = {};
  ContinueOptimization(StopAtOutliers(options, *adjusted), adjusted);
  if (RemoveOutliers(pattern, adjusted) != RemovalResult::kNone)
    ContinueOptimization(options, adjusted);
}

double EstimateFlatnessError(const Pattern& pattern,
                             const AdjustmentOptions& options,
                             AdjustmentResult adjusted) {
  const auto& cameras = adjusted.state.cameras;
  if (std::any_of(cameras.begin(), cameras.end(), [](const auto& camera) {
        return IsParametricModel(camera->Name()) && !IsFixed(*camera);
      }))
    return 0;
  AdjustmentOptions free = options;
  free.fix_points = false;
  EstimateStaticDeformation(&adjusted);
  ContinueOptimization(free, &adjusted);
  if (!adjusted.state.HasStaticDeformation()) return 0;
  AlignBoards(pattern, &adjusted);
  double height_m = 0;
  for (const Board& board : MakeEstimatedPattern(pattern, adjusted).boards)
    if (!board.IsPointSet())  // point sets may be non-planar
      height_m = std::max(height_m, MeasureFlatness(board).rms_height_m);
  return height_m;
}

void OptimizeModel(const Pattern& pattern, const std::string& model,
                   const std::vector<double>& knot_spacings_px,
                   const AdjustmentOptions& options,
                   AdjustmentResult* adjusted) {
  if (!IsParametricModel(model)) FitBaseModels(options, adjusted);
  OptimizeWithRigidBoards(pattern, model, knot_spacings_px, options, adjusted);
  FinishModel(pattern, model, options, adjusted);
}

void FinishModel(const Pattern& pattern, const std::string& model,
                 const AdjustmentOptions& options, AdjustmentResult* adjusted) {
  if (!IsParametricModel(model) && !options.rigid_boards) {
    AdjustmentResult rigid = *adjusted;
    EstimateDeformation(pattern, options, adjusted);
    if (HasDiverged(*adjusted, rigid)) *adjusted = std::move(rigid);
  }
  FinalizeCameras(adjusted);
}

void FinalizeCameras(AdjustmentResult* adjusted) {
  for (size_t c = 0; c < adjusted->state.cameras.size(); ++c) {
    std::unique_ptr<CameraModel>& camera = adjusted->state.cameras[c];
    if (const ParametricModel* lens = camera->Parametric())
      camera = lens->CloneWithArea(
          ComputeCalibratedArea(adjusted->problem, static_cast<int>(c)));
    LimitUnobservedControlPoints(adjusted->problem, static_cast<int>(c),
                                 camera.get());
  }
  CenterLines(&adjusted->state);
}

void AlignBoards(const Pattern& pattern, AdjustmentResult* adjusted) {
  const CalibrationProblem& problem = adjusted->problem;
  // The pose of a rigid target is the pose of the board that defines its frame.
  std::vector<std::set<int>> poses(pattern.boards.size());
  std::vector<bool> is_seen(pattern.boards.size());
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const int board = problem.boards[v];
    const View& view = problem.views[v];
    const int frame = view.place < 0 ? board : problem.frames[board];
    poses[frame].insert(view.pose);
    is_seen[board] = is_seen[frame] = true;
  }
  std::vector<AlignedBoard> boards;
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    if (!is_seen[b]) continue;
    AlignedBoard board = {problem.first_points[b],
                          pattern.boards[b].points,
                          {poses[b].begin(), poses[b].end()}};
    if (!problem.frames.empty()) {
      board.body = problem.frames[b];
      board.place = problem.places[b];
    }
    boards.push_back(std::move(board));
  }
  AlignToNominal(boards, &adjusted->state);
}

bool HavePointsMoved(const AdjustmentResult& adjusted) {
  constexpr double kRoundingM = 1e-9;
  constexpr Eigen::Index kLeast = 3;  // minimum to determine a rigid motion
  const std::vector<int>& firsts = adjusted.problem.first_points;
  const std::vector<Eigen::Vector3d>& points = adjusted.state.points;
  for (size_t b = 0; b < firsts.size(); ++b) {
    const size_t end = b + 1 < firsts.size() ? firsts[b + 1] : points.size();
    const Eigen::Index count = static_cast<Eigen::Index>(end) - firsts[b];
    Eigen::Matrix3Xd from(3, count), to(3, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      from.col(i) = adjusted.problem.nominal[firsts[b] + i];
      to.col(i) = points[firsts[b] + i];
    }
    // The alignment removes the part of static deformation that moves and
    // scales a board.
    if (count >= kLeast)
      from = (Eigen::umeyama(from, to) * from.colwise().homogeneous())
                 .topRows<3>()
                 .eval();
    if (((from - to).colwise().norm().array() > kRoundingM).any()) return true;
  }
  return false;
}

Pattern MakeEstimatedPattern(const Pattern& pattern,
                             const AdjustmentResult& adjusted) {
  Pattern result = pattern;
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    const int first = adjusted.problem.first_points[b];
    for (int i = 0; i < pattern.boards[b].num_points(); ++i)
      result.boards[b].points[i] = adjusted.state.DeformedPoint(first + i);
  }
  return result;
}

}  // namespace raygrid
