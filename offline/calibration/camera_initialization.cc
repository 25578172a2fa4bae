#include "calibration/camera_initialization.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "calibration/board_rotations.h"
#include "calibration/camera_adjustment.h"
#include "calibration/even_selection.h"
#include "camera/fixed_camera.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "evaluation/residual_statistics.h"
#include "initialization/generic_initialization.h"
#include "initialization/parametric_initialization.h"
#include "initialization/radial_initialization.h"

namespace raygrid {
namespace {

// Pose estimation of a view fails if its median error exceeds this fraction of
// the image width.
constexpr double kMaxRelativeMedian = 0.02;

double MedianError(const AdjustmentState& state, const View& view,
                   const Pose& pose) {
  AdjustmentState alone = state;
  alone.rig_from_pattern = {pose};
  View only = view;
  only.pose = 0;
  std::vector<double> norms;
  for (const Residual& residual : ComputeResiduals(alone, {only}, 1))
    norms.push_back(residual.valid ? residual.error_px.norm() : INFINITY);
  return Quantile(norms, 0.5);
}

// Returns the views whose poses can be estimated with a camera, and their
// poses.
AdjustmentResult LocalizeWithCamera(const CameraModel& lens,
                                    const AdjustmentResult& all,
                                    int num_threads) {
  AdjustmentResult localized = all;
  CalibrationProblem& problem = localized.problem;
  AdjustmentState& state = localized.state;
  state.SetCamera(lens);
  state.points = problem.nominal;
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(lens, 0, problem, num_threads);
  std::vector<Pose> kept;
  std::vector<bool> remove(poses.size(), true);
  for (size_t v = 0; v < poses.size(); ++v) {
    remove[v] =
        !poses[v] || !(MedianError(state, problem.views[v], *poses[v]) <
                       kMaxRelativeMedian * problem.image_sizes[0].width);
    if (remove[v])
      localized.rejected_images.push_back(
          {problem.images[v], "pose estimation failed"});
    else
      kept.push_back(*poses[v]);
  }
  RemoveViews(remove, &problem);
  // Poses are ordered like the views, and each view has a separate pose.
  state.rig_from_pattern = kept;
  return localized;
}

int NumImages(const CalibrationProblem& problem) {
  return static_cast<int>(
      std::set<std::string>(problem.images.begin(), problem.images.end())
          .size());
}

// Removes features with gross reprojection errors: in a narrow field of view, a
// few of them distort the model despite the Huber loss. Uses the criterion of
// the paper's supplement with a much larger limit, since the model is still
// rough.
void RemoveOutlierFeatures(const Pattern& pattern, int num_threads,
                           AdjustmentResult* adjusted) {
  constexpr double kRanges = 30;
  CalibrationProblem& problem = adjusted->problem;
  const std::vector<Residual> residuals =
      ComputeResiduals(adjusted->state, problem.views, num_threads);
  std::vector<double> norms;
  for (const Residual& residual : residuals)
    if (residual.valid) norms.push_back(residual.error_px.norm());
  const double q1 = Quantile(norms, 0.25), q3 = Quantile(norms, 0.75);
  const double limit_px = q3 + kRanges * (q3 - q1);
  size_t index = 0;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    std::vector<Observation> kept;
    for (const Observation& observation : problem.views[v].observations) {
      const Residual& residual = residuals[index++];
      if (!residual.valid || residual.error_px.norm() <= limit_px) {
        kept.push_back(observation);
        continue;
      }
      const Feature feature =
          problem.GetFeature(pattern, static_cast<int>(v), observation);
      adjusted->rejected_features[0].push_back(
          {problem.images[v], feature.board, feature.column, feature.row,
           observation.pixel, residual.error_px});
    }
    problem.views[v].observations = std::move(kept);
  }
}

// Selects enough views and features for the roughly twelve parameters of a
// parametric model.
AdjustmentResult Subsample(const AdjustmentResult& all) {
  constexpr size_t kMaxViews = 100, kMaxFeatures = 60;
  AdjustmentResult thinned = all;
  CalibrationProblem& problem = thinned.problem;
  std::vector<size_t> indices(problem.views.size());
  std::iota(indices.begin(), indices.end(), 0);
  std::vector<bool> remove(indices.size(), true);
  for (const size_t v : SelectEvenly(indices, kMaxViews)) remove[v] = false;
  RemoveViews(remove, &problem);
  for (View& view : problem.views)
    view.observations = SelectEvenly(view.observations, kMaxFeatures);
  return thinned;
}

// Estimates poses and refines the camera in two rounds: with a better camera,
// more poses can be estimated, and with higher accuracy.
std::optional<AdjustmentResult> OptimizeFrom(const CameraModel& start,
                                             const Pattern& pattern,
                                             const AdjustmentResult& all,
                                             const AdjustmentOptions& options) {
  constexpr int kRounds = 2;
  AdjustmentOptions rough = options;
  rough.max_iterations = 0;  // stop after estimating the prior
  std::optional<AdjustmentResult> adjusted;
  for (int round = 0; round < kRounds; ++round) {
    const std::unique_ptr<CameraModel> lens =
        adjusted ? adjusted->state.camera().Clone() : start.Clone();
    adjusted = LocalizeWithCamera(*lens, all, options.num_threads);
    if (NumImages(adjusted->problem) < kMinImages) return std::nullopt;
    RemoveOutlierFeatures(pattern, options.num_threads, &*adjusted);
    adjusted->summary =
        RefineCameras(adjusted->problem, rough, &adjusted->state);
  }
  return adjusted;
}

// Misfit of a camera: the fraction of all features whose view has no pose, or
// which have no projection or observation direction, and the mean error.
struct Misfit {
  double unexplained_fraction = 0;
  double mean_px = 0;  ///< over all features, capped per feature
};

// Returns the size in pixels of one pixel of a 640 px wide image, the size for
// which the limits below were chosen: errors in pixels grow with the image
// size.
double ComputePixelScale(const CalibrationProblem& problem) {
  constexpr double kWidth = 640;
  const ImageSize& size = problem.image_sizes[0];
  return std::max(1.0, std::max(size.width, size.height) / kWidth);
}

Misfit ComputeMisfit(const AdjustmentResult& adjusted, size_t num_features) {
  const double cap_px = 5 * ComputePixelScale(adjusted.problem);
  size_t index = 0, explained = 0;
  double sum = 0;
  for (const View& view : adjusted.problem.views) {
    for (const Observation& observation : view.observations) {
      const Residual& residual = adjusted.summary.residuals[index++];
      if (!residual.valid ||
          !adjusted.state.camera().Unproject(observation.pixel))
        continue;
      ++explained;
      sum += std::min(residual.error_px.norm(), cap_px);
    }
  }
  const auto count = static_cast<double>(num_features);
  const double unexplained = count - static_cast<double>(explained);
  return {unexplained / count, (sum + cap_px * unexplained) / count};
}

// Factors on the errors of initial cameras when they are compared.
double GetComplexityPenalty(const CameraModel& start) {
  // A pinhole model with distortion is preferred if the errors are similar:
  // beyond the outermost features, in the image corners, it extrapolates better
  // than a polynomial in the angle of incidence (simulated lens with a field of
  // view of 62 degrees: 0.10 px instead of 0.21 px in the worst corner).
  constexpr double kPinholeErrorFactor = 0.8;
  // A grid can represent any lens, but extrapolates poorly.
  constexpr double kGridErrorFactor = 2;
  if (start.Name() == models::kOpenCv) return kPinholeErrorFactor;
  return IsParametricModel(start.Name()) ? 1 : kGridErrorFactor;
}

size_t NumFeatures(const CalibrationProblem& problem) {
  size_t count = 0;
  for (const View& view : problem.views) count += view.observations.size();
  return count;
}

// Estimates initial cameras by linear methods: pinholes, and radially symmetric
// lenses with any field of view.
std::vector<std::unique_ptr<CameraModel>> ListParametricInitialValues(
    const Dataset& dataset, const Pattern& pattern) {
  std::vector<std::unique_ptr<CameraModel>> starts;
  if (const auto radial = InitializeFromRadialLines(dataset, pattern))
    starts.push_back(radial->Clone());
  if (const auto pinhole = InitializeFromPlanarBoards(dataset, pattern))
    starts.push_back(pinhole->Clone());
  return starts;
}

// Estimates an initial generic grid for an arbitrary central lens over the
// calibrated area.
std::optional<CentralGeneric> MakeInitialGenericGrid(
    const Dataset& dataset, const Pattern& pattern,
    const CalibrationProblem& problem, int num_threads) {
  GenericInitializationOptions options;
  options.num_threads = num_threads;
  options.area = ComputeCalibratedArea(problem, 0);
  const auto generic = InitializeFromThreeViews(dataset, pattern, options);
  if (!generic) return std::nullopt;
  return generic->camera;
}

// Optimizes initial cameras with a subset of the features, and keeps the best
// one.
class InitializationTrials {
 public:
  InitializationTrials(const Pattern& pattern, const AdjustmentResult& all,
                       const AdjustmentOptions& options)
      : pattern_(pattern),
        thinned_(Subsample(all)),
        num_features_(NumFeatures(thinned_.problem)),
        options_(options) {
    options_.fix_points = true;
  }

  void Try(const CameraModel& start) {
    const auto adjusted = OptimizeFrom(start, pattern_, thinned_, options_);
    if (!adjusted) return;
    const Misfit misfit = ComputeMisfit(*adjusted, num_features_);
    const double weighted =
        misfit.mean_px * GetComplexityPenalty(adjusted->state.camera());
    if (best_ && weighted >= min_weighted_misfit_) return;
    best_ = adjusted;
    best_misfit_ = misfit;
    min_weighted_misfit_ = weighted;
  }

  // Whether the error is small enough for a lens with local distortion.
  bool HasSmallError() const {
    return best_ && best_misfit_.mean_px < ComputePixelScale(thinned_.problem);
  }

  // Whether the best initial camera is good enough for calibration.
  bool HasAcceptableCamera() const {
    constexpr double kMaxUnexplainedFraction = 0.25;
    return best_ &&
           best_misfit_.unexplained_fraction <= kMaxUnexplainedFraction;
  }

  // Returns the best initial camera; throws if it is not good enough.
  const AdjustmentResult& GetBest() const {
    if (HasAcceptableCamera()) return *best_;
    if (!best_)
      throw Error(
          ExitCode::kInitializationFailed,
          "initialization failed: no initial camera fits these features; check "
          "columns and rows of the pattern, and add tilted views");
    throw Error(
        ExitCode::kInitializationFailed,
        fmt::format("initialization failed: the initial camera fits only "
                    "{:.0f} % of {} features; check the pattern, and add "
                    "tilted views that cover the image",
                    100 * (1 - best_misfit_.unexplained_fraction),
                    num_features_));
  }

 private:
  const Pattern& pattern_;
  AdjustmentResult thinned_;
  size_t num_features_;
  AdjustmentOptions options_;
  std::optional<AdjustmentResult> best_;
  Misfit best_misfit_;
  double min_weighted_misfit_ = INFINITY;
};

// Tries all initializations that do not depend on a previous camera.
void TryAll(const Dataset& dataset, const Pattern& pattern,
            const CalibrationProblem& problem, int num_threads,
            InitializationTrials* trials) {
  for (const auto& start : ListParametricInitialValues(dataset, pattern))
    trials->Try(*start);
  if (trials->HasSmallError()) return;
  const auto grid =
      MakeInitialGenericGrid(dataset, pattern, problem, num_threads);
  if (!grid) return;
  const Area features = ComputeFeatureArea(problem, 0);
  trials->Try(
      *FitParametricModel(models::kCentralRadial, *grid, features, {true})
           .model);
  trials->Try(*grid);
}

void RequireImages(const CalibrationProblem& problem) {
  if (NumImages(problem) < kMinImages)
    throw Error(ExitCode::kInsufficientData,
                fmt::format("only {} {} with at least {} features on a board: "
                            "at least {} are required, and {} are recommended",
                            NumImages(problem),
                            NumImages(problem) == 1 ? "image" : "images",
                            kMinViewFeatures, kMinImages, 20));
}

}  // namespace

AdjustmentResult InitializeCamera(const Dataset& dataset,
                                  const Pattern& pattern,
                                  const AdjustmentOptions& options,
                                  AreaChoice area, const CameraModel* known) {
  AdjustmentResult all;
  all.problem = BuildProblem({dataset}, pattern, &all.rejected_images);
  all.problem.area = area;
  all.rejected_features.resize(1);  // single camera
  RequireImages(all.problem);
  InitializationTrials trials(pattern, all, options);
  if (known) trials.Try(*known);
  if (!trials.HasAcceptableCamera())
    TryAll(dataset, pattern, all.problem, options.num_threads, &trials);
  AdjustmentResult adjusted = LocalizeWithCamera(
      trials.GetBest().state.camera(), all, options.num_threads);
  RemoveOutlierFeatures(pattern, options.num_threads, &adjusted);
  return adjusted;
}

AdjustmentResult InitializeKnownCamera(const CameraModel& camera,
                                       const Dataset& dataset,
                                       const Pattern& pattern, AreaChoice area,
                                       int num_threads) {
  AdjustmentResult known =
      LocalizeDatasetViews(FixedCamera(camera), dataset, pattern, num_threads);
  if (known.problem.views.empty())
    throw Error(ExitCode::kInsufficientData,
                "no target pose could be estimated with the known intrinsics; "
                "check that they belong to this camera, and the pattern");
  known.problem.area = area;
  known.rejected_features.resize(1);
  return known;
}

}  // namespace raygrid
