#include "calibration/camera_adjustment.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "adjustment/distortion_prior.h"
#include "adjustment/matern_field.h"
#include "adjustment/smoothness_prior.h"
#include "calibration/extrapolated_grid.h"
#include "calibration/polynomial_grid.h"
#include "calibration/prior_grid.h"
#include "camera/fixed_camera.h"
#include "camera/model_fitting.h"
#include "camera/noncentral_generic.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Fixes the points of the pattern at their nominal positions.
AdjustmentOptions WithFixedPoints(AdjustmentOptions options) {
  options.fix_points = true;
  options.should_accept = {};
  return options;
}

// Optimizes first with fixed points, which is a small problem and tolerates a
// rough initialization, and then with free points unless they are to be fixed.
// Grids would fit the errors of fixed points, so the first stage ends early for
// them. Parametric models cannot do so, and require a good initialization.
AdjustmentSummary OptimizeInTwoStages(const CalibrationProblem& problem,
                                      const AdjustmentOptions& options,
                                      GaussianPrior* prior,
                                      AdjustmentState* state) {
  prior->points_mean = problem.nominal;
  state->SetModes({}, DeformationScope::kBoard);
  AdjustmentOptions first =
      options.fix_points ? options : MakeInitializationOptions(options);
  first.is_initialization =
      !options.fix_points && !AreParametric(CopyCameras(*state));
  const AdjustmentSummary summary =
      OptimizeWithLearnedPrior(problem.views, first, prior, state);
  if (options.fix_points) return summary;
  state->SetModes(GetDeformationModes(problem), DeformationScope::kBoard);
  return OptimizeWithLearnedPrior(problem.views, options, prior, state);
}

int NumFeatures(const CalibrationProblem& problem, int camera) {
  size_t count = 0;
  for (const View& view : problem.views)
    if (view.camera == camera) count += view.observations.size();
  return static_cast<int>(count);
}

// Makes a camera prior that is centred on the current parameters.
CameraPrior MakePriorAround(const CameraModel& camera,
                            const CalibrationProblem& problem, int index) {
  if (IsFixed(camera)) return {};
  if (const ParametricModel* lens = camera.Parametric())
    return MakeDistortionPrior(*lens, ComputeCalibratedArea(problem, index),
                               NumFeatures(problem, index));
  return MakeSmoothnessPrior(FitPolynomialGrid(MakeCentral(camera)),
                             ObservedPixels(problem, index));
}

// Optimizes parametric cameras, starting from the current state.
AdjustmentSummary OptimizeParametricCameras(const CalibrationProblem& problem,
                                            const AdjustmentOptions& options,
                                            GaussianPrior* prior,
                                            AdjustmentState* state) {
  *prior = {};
  for (size_t c = 0; c < state->cameras.size(); ++c)
    prior->cameras.push_back(
        MakePriorAround(*state->cameras[c], problem, static_cast<int>(c)));
  return OptimizeInTwoStages(problem, options, prior, state);
}

// Returns the number of control points of a radial spline that the features can
// determine. The prior smooths superfluous control points
// (offline/calibration/DESIGN.md).
int CountSamples(int num_features) {
  constexpr int kMinSamples = 24, kMaxSamples = 96, kFeaturesPerSample = 20;
  return std::clamp(num_features / kFeaturesPerSample, kMinSamples,
                    kMaxSamples);
}

// Replaces an initial camera by a parametric model that is fitted to it. If the
// initial camera has no optical axis, the fit estimates the axis, and the
// camera's poses are rotated accordingly.
void SetCameraModel(const std::string& model, const CameraModel& lens,
                    const CalibrationProblem& problem, int camera,
                    AdjustmentState* state) {
  FitOptions options;
  options.free_rotation = !IsParametricModel(lens.Name());
  options.num_knots = CountSamples(NumFeatures(problem, camera));
  const FittedModel fitted = FitParametricModel(
      model, lens, ComputeFeatureArea(problem, camera), options);
  state->cameras[camera] = fitted.model->Clone();
  if (!options.free_rotation) return;
  Pose& pose = state->camera_from_rig[camera];
  pose = Pose{fitted.model_from_camera, Eigen::Vector3d::Zero()} * pose;
  state->MoveRigToFirstCamera();
}

// Returns the prior mean of a grid: the initial grid if it comes from a prior
// camera or a parametric model. All other initial cameras were fitted to the
// same features and contain their errors, so a polynomial approximation is
// used.
CentralGeneric PredictGrid(const CalibrationProblem& problem,
                           const CameraModel& lens,
                           const CentralGeneric& start) {
  return problem.like || IsParametricModel(lens.Name())
             ? start
             : FitPolynomialGrid(start);
}

// Optimizes non-central cameras, initialized from optimized central grids.
// Points are fixed at their nominal positions, since free points would absorb
// non-central effects.
AdjustmentSummary OptimizeNonCentralGrids(const CalibrationProblem& problem,
                                          const InitialValues& starts,
                                          const AdjustmentOptions& options,
                                          GaussianPrior* prior,
                                          AdjustmentState* state) {
  OptimizeGrids(problem, starts, WithFixedPoints(options), prior, state);
  *prior = {};
  for (size_t c = 0; c < starts.lenses.size(); ++c) {
    if (IsFixed(*starts.lenses[c])) {
      prior->cameras.emplace_back();
      continue;
    }
    prior->cameras.push_back(MakeNonCentralPrior(
        PredictGrid(problem, *starts.lenses[c],
                    MakeInitialGrid(problem, c, starts)),
        ObservedPixels(problem, static_cast<int>(c)),
        ComputeMeanDistance(problem, c, *state), starts.GetBaseModel(c)));
    state->cameras[c] =
        NonCentralGeneric(MakeCentral(*state->cameras[c])).Clone();
  }
  return OptimizeInTwoStages(problem, options, prior, state);
}

// Continues from the state of a warm start, with its precisions times a factor
// per camera.
AdjustmentSummary ContinueFrom(const AdjustmentResult& other,
                               const std::vector<double>& factors,
                               const CalibrationProblem& problem,
                               const AdjustmentOptions& options,
                               GaussianPrior* prior, AdjustmentState* state) {
  const double variance = std::pow(other.summary.noise_px, 2);
  for (size_t c = 0; c < factors.size(); ++c) {
    std::vector<PriorGroup>& groups = prior->cameras[c].groups;
    for (size_t g = 0; g < groups.size(); ++g)
      groups[g].SetPrecision(
          other.prior.cameras[c].groups[g].weight * factors[c], variance);
  }
  prior->points_mean = problem.nominal;
  prior->points_precision = other.prior.points_precision;
  prior->deformation_precisions = other.prior.deformation_precisions;
  AdjustmentState warm = other.state;
  warm.cameras = std::move(state->cameras);
  *state = std::move(warm);
  return OptimizeWithLearnedPrior(problem.views, options, prior, state);
}

// Continues from grids with the same prior on the continuous field: sums of
// squared differences of order n are proportional to the knot spacing to the
// power of 2 n - 2.
AdjustmentSummary ContinueFromGrids(const CalibrationProblem& problem,
                                    const InitialValues& starts,
                                    const AdjustmentOptions& options,
                                    GaussianPrior* prior,
                                    AdjustmentState* state) {
  const AdjustmentResult& other = *starts.adjusted;
  std::vector<double> factors;
  for (size_t c = 0; c < state->cameras.size(); ++c) {
    const CameraModel& from = *other.state.cameras[c];
    std::unique_ptr<CameraModel>& to = state->cameras[c];
    const double ratio = static_cast<double>(to->DirectionGrid()->columns()) /
                         static_cast<double>(from.DirectionGrid()->columns());
    factors.push_back(std::pow(ratio, 2 * kMaternOrder - 2));
    to = to->FittedTo(from);
  }
  return ContinueFrom(other, factors, problem, options, prior, state);
}

// Whether poses and points match the problem, which loses the poses of rejected
// images.
bool HasSameImages(const AdjustmentResult* adjusted,
                   const AdjustmentState& state) {
  return adjusted && adjusted->state.rig_from_pattern.size() ==
                         state.rig_from_pattern.size();
}

}  // namespace

CameraModels CopyCameras(const AdjustmentState& state) {
  CameraModels cameras;
  for (const auto& camera : state.cameras) cameras.push_back(camera->Clone());
  return cameras;
}

bool AreParametric(const CameraModels& lenses) {
  return std::all_of(lenses.begin(), lenses.end(), [](const auto& lens) {
    return IsParametricModel(lens->Name());
  });
}

AdjustmentOptions MakeInitializationOptions(AdjustmentOptions options) {
  options.fix_points = true;
  options.should_accept = {};
  options.max_iterations = 0;
  return options;
}

double ComputeMedianErrorPx(const std::vector<Residual>& residuals) {
  std::vector<double> norms;
  for (const Residual& residual : residuals)
    norms.push_back(residual.valid ? residual.error_px.norm() : INFINITY);
  return Quantile(norms, 0.5);
}

CentralGeneric MakeInitialGrid(const CalibrationProblem& problem, size_t camera,
                               const InitialValues& starts) {
  const Area area = ComputeCalibratedArea(problem, static_cast<int>(camera));
  const double knot_spacing_px = starts.knot_spacings_px[camera];
  const int columns = NumControlPoints(area.width(), knot_spacing_px),
            rows = NumControlPoints(area.height(), knot_spacing_px);
  const CameraModel& lens = *starts.lenses[camera];
  return problem.like ? FitGridToPrior(*problem.like, lens, area, columns, rows)
                      : FitExtrapolatedGrid(lens, area, columns, rows);
}

double ComputeMeanDistance(const CalibrationProblem& problem, size_t camera,
                           const AdjustmentState& state) {
  double sum = 0;
  int count = 0;
  for (const View& view : problem.views) {
    if (view.camera != static_cast<int>(camera)) continue;
    const Pose pose = state.ComputeCameraFromPattern(view);
    for (const Observation& observation : view.observations) {
      sum += (pose * state.points[observation.point]).norm();
      ++count;
    }
  }
  return sum / count;
}

AdjustmentSummary OptimizeParametricCameras(const std::string& model,
                                            const CalibrationProblem& problem,
                                            const CameraModels& lenses,
                                            const AdjustmentOptions& options,
                                            GaussianPrior* prior,
                                            AdjustmentState* state) {
  for (size_t c = 0; c < lenses.size(); ++c) {
    state->cameras[c] = lenses[c]->Clone();
    if (IsFixed(*lenses[c])) continue;
    // The radial model is refitted even if the name matches, since it may have
    // been initialized with fewer control points.
    if (lenses[c]->Name() != model || model == models::kCentralRadial)
      SetCameraModel(model, *lenses[c], problem, static_cast<int>(c), state);
  }
  return OptimizeParametricCameras(problem, options, prior, state);
}

AdjustmentSummary OptimizeGrids(const CalibrationProblem& problem,
                                const InitialValues& starts,
                                const AdjustmentOptions& options,
                                GaussianPrior* prior, AdjustmentState* state) {
  *prior = {};
  std::vector<BSplineSurface> spread;
  if (problem.like && problem.prior_population)
    spread = problem.prior_population->FitSurfaces(problem.like->area());
  for (size_t c = 0; c < starts.lenses.size(); ++c) {
    if (IsFixed(*starts.lenses[c])) {
      prior->cameras.emplace_back();
      state->cameras[c] = starts.lenses[c]->Clone();
      continue;
    }
    const CentralGeneric base = MakeInitialGrid(problem, c, starts);
    prior->cameras.push_back(
        MakeSmoothnessPrior(PredictGrid(problem, *starts.lenses[c], base),
                            ObservedPixels(problem, static_cast<int>(c)),
                            starts.GetBaseModel(c), spread));
    state->cameras[c] = base.Clone();
  }
  return HasSameImages(starts.adjusted, *state)
             ? ContinueFromGrids(problem, starts, options, prior, state)
             : OptimizeInTwoStages(problem, options, prior, state);
}

AdjustmentSummary OptimizeCameras(const std::string& model,
                                  const CalibrationProblem& problem,
                                  const InitialValues& starts,
                                  const AdjustmentOptions& options,
                                  GaussianPrior* prior,
                                  AdjustmentState* state) {
  if (IsParametricModel(model))
    return OptimizeParametricCameras(model, problem, starts.lenses, options,
                                     prior, state);
  if (model == models::kNonCentralGeneric)
    return OptimizeNonCentralGrids(problem, starts, options, prior, state);
  return OptimizeGrids(problem, starts, options, prior, state);
}

AdjustmentSummary RefineCameras(const CalibrationProblem& problem,
                                const AdjustmentOptions& options,
                                AdjustmentState* state) {
  GaussianPrior prior;
  return OptimizeParametricCameras(problem, options, &prior, state);
}

}  // namespace raygrid
