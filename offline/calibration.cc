#include "calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>

#include "adjustment/bundle_adjustment.h"
#include "adjustment/metric_scale.h"
#include "camera/central_generic.h"
#include "camera/opencv.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "initialization/localization.h"
#include "initialization/parametric_start.h"

namespace raygrid {
namespace {

constexpr int kMinImages = 3;
constexpr size_t kMinFeatures = 8;           // in a view
constexpr double kMaxStartErrorPart = 0.05;  // of the image's width
constexpr int kMaxGridParameters = 2600;     // tried by --cell-px auto

class Stopwatch {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

// The observations as adjustment wants them, and what they came from.
struct Problem {
  ImageSize image_size;
  std::vector<View> views;
  std::vector<std::string> images;  // of each view
  std::vector<int> boards;          // index in the pattern, of each view
  std::vector<int> first_points;    // of each board
  std::vector<Eigen::Vector3d> nominal;
};

// Where a point index leads back to.
Feature FeatureOf(const Problem& problem, const Pattern& pattern, int view,
                  const Observation& observation) {
  const Board& board = pattern.boards[problem.boards[view]];
  const int index =
      observation.point - problem.first_points[problem.boards[view]];
  return {board.id, index % board.columns, index / board.columns,
          observation.pixel};
}

Problem EmptyProblem(const Dataset& dataset, const Pattern& pattern) {
  Problem problem;
  problem.image_size = dataset.image_size;
  for (const Board& board : pattern.boards) {
    problem.first_points.push_back(static_cast<int>(problem.nominal.size()));
    problem.nominal.insert(problem.nominal.end(), board.points.begin(),
                           board.points.end());
  }
  return problem;
}

// One view for each board in each image.
Problem BuildProblem(const Dataset& dataset, const Pattern& pattern,
                     std::vector<RejectedImage>* rejected) {
  Problem problem = EmptyProblem(dataset, pattern);
  for (const ImageFeatures& image : dataset.images) {
    bool used = false;
    for (size_t b = 0; b < pattern.boards.size(); ++b) {
      const Board& board = pattern.boards[b];
      View view;
      for (const Feature& feature : image.features)
        if (feature.board == board.id)
          view.observations.push_back(
              {problem.first_points[b] +
                   board.PointIndex(feature.column, feature.row),
               feature.pixel});
      if (view.observations.size() < kMinFeatures) continue;
      problem.views.push_back(std::move(view));
      problem.images.push_back(image.image);
      problem.boards.push_back(static_cast<int>(b));
      used = true;
    }
    if (!used)
      rejected->push_back({image.image, fmt::format("only {} features",
                                                    image.features.size())});
  }
  return problem;
}

void RemoveViews(const std::vector<bool>& remove, Problem* problem,
                 AdjustmentState* state) {
  size_t kept = 0;
  for (size_t v = 0; v < problem->views.size(); ++v) {
    if (remove[v]) continue;
    if (kept != v) problem->views[kept] = std::move(problem->views[v]);
    problem->images[kept] = problem->images[v];
    problem->boards[kept] = problem->boards[v];
    state->camera_from_pattern[kept] = state->camera_from_pattern[v];
    ++kept;
  }
  problem->views.resize(kept);
  problem->images.resize(kept);
  problem->boards.resize(kept);
  state->camera_from_pattern.resize(kept);
}

// The rectangle of all features, rounded outwards to what a blob can say.
Area FeatureArea(const Problem& problem) {
  Area area = {1e9, 1e9, -1e9, -1e9};
  for (const View& view : problem.views) {
    for (const Observation& observation : view.observations) {
      const Eigen::Vector2d& p = observation.pixel;
      area = {std::min(area.x0, p.x()), std::min(area.y0, p.y()),
              std::max(area.x1, p.x()), std::max(area.y1, p.y())};
    }
  }
  constexpr double kUnit = 65536;
  return {
      std::floor(area.x0 * kUnit) / kUnit, std::floor(area.y0 * kUnit) / kUnit,
      std::ceil(area.x1 * kUnit) / kUnit, std::ceil(area.y1 * kUnit) / kUnit};
}

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

std::vector<PointOnPixel> MatchesOf(
    const View& view, const std::vector<Eigen::Vector3d>& points) {
  std::vector<PointOnPixel> matches;
  for (const Observation& observation : view.observations)
    matches.push_back({points[observation.point], observation.pixel});
  return matches;
}

// Poses of all views with the starting camera; those without one are removed.
AdjustmentState StartingState(const OpenCvModel& start, int num_threads,
                              Problem* problem,
                              std::vector<RejectedImage>* rejected) {
  AdjustmentState state;
  state.camera = start.Clone();
  state.points = problem->nominal;
  const int num_views = static_cast<int>(problem->views.size());
  state.camera_from_pattern.resize(num_views);
  std::vector<char> failed(num_views, 0);
  ParallelFor(num_views, num_threads, [&](int v) {
    const auto pose =
        Localize(start, MatchesOf(problem->views[v], problem->nominal));
    if (!pose) {
      failed[v] = 1;
      return;
    }
    AdjustmentState alone;
    alone.camera = start.Clone();
    alone.points = problem->nominal;
    alone.camera_from_pattern = {*pose};
    failed[v] = !(RmsOf(ComputeResiduals(alone, {problem->views[v]}, 1)) <
                  kMaxStartErrorPart * problem->image_size.width);
    state.camera_from_pattern[v] = *pose;
  });
  std::vector<bool> remove(failed.begin(), failed.end());
  for (int v = 0; v < num_views; ++v)
    if (remove[v])
      rejected->push_back(
          {problem->images[v], "no pose explains its features"});
  RemoveViews(remove, problem, &state);
  return state;
}

// The pattern's points stay where they are nominally.
AdjustmentOptions WithFixedPoints(AdjustmentOptions options) {
  options.fix_points = true;
  return options;
}

// First with fixed points, a small problem from a rough start; then, if they
// may move, with all of them, from a good start.
AdjustmentSummary AdjustInTwoSteps(const Problem& problem,
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

AdjustmentSummary AdjustParametric(const Problem& problem,
                                   const AdjustmentOptions& options,
                                   AdjustmentState* state) {
  GaussianPrior prior = DistortionPrior(
      dynamic_cast<const OpenCvModel&>(*state->camera), FeatureArea(problem));
  return AdjustInTwoSteps(problem, options, &prior, state);
}

// The grid camera, around a parametric lens.
AdjustmentSummary AdjustGrid(const Problem& problem, const CameraModel& lens,
                             double cell_px, const AdjustmentOptions& options,
                             AdjustmentState* state) {
  const Area area = FeatureArea(problem);
  const CentralGeneric base =
      FitCentralGeneric(lens, area, NumControlPoints(area.width(), cell_px),
                        NumControlPoints(area.height(), cell_px));
  GaussianPrior prior = SmoothnessPrior(base);
  state->camera = base.Clone();
  return AdjustInTwoSteps(problem, options, &prior, state);
}

// Residuals beyond the third quartile + 6 interquartile ranges (paper's
// supplement, "Bundle adjustment details") leave the problem.
std::vector<FeatureResidual> RemoveOutliers(
    const Pattern& pattern, const std::vector<Residual>& residuals,
    Problem* problem) {
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
          FeatureOf(*problem, pattern, static_cast<int>(v), observation);
      removed.push_back({problem->images[v], feature.board, feature.column,
                         feature.row, observation.pixel, residual.error_px});
    }
    problem->views[v].observations = std::move(kept);
  }
  return removed;
}

// A calibration without its figures.
struct Adjusted {
  Problem problem;
  AdjustmentState state;
  AdjustmentSummary summary;
  std::vector<RejectedImage> rejected_images;
  std::vector<FeatureResidual> rejected_features;
};

// A lens beyond the parametric model shows in features that it gives no
// direction to, or whose points it does not project.
constexpr double kMaxUnexplainedPart = 0.05;
void RequireParametricLens(const Adjusted& adjusted) {
  size_t index = 0, unexplained = 0;
  for (const View& view : adjusted.problem.views)
    for (const Observation& observation : view.observations)
      unexplained += !adjusted.summary.residuals[index++].valid ||
                     !adjusted.state.camera->Unproject(observation.pixel);
  if (static_cast<double>(unexplained) >
      kMaxUnexplainedPart * static_cast<double>(index))
    throw Error(
        ExitCode::kInitialization,
        fmt::format("the starting lens explains only {} of {} features; this "
                    "version starts from pinhole-like lenses, up to about 120 "
                    "degrees of view",
                    index - unexplained, index));
}

// Start and parametric adjustment; throws Error where that is impossible.
Adjusted AdjustStart(const Dataset& dataset, const Pattern& pattern,
                     const AdjustmentOptions& options) {
  Adjusted adjusted;
  adjusted.problem = BuildProblem(dataset, pattern, &adjusted.rejected_images);
  const auto require_images = [&adjusted] {
    const std::set<std::string> images(adjusted.problem.images.begin(),
                                       adjusted.problem.images.end());
    if (static_cast<int>(images.size()) < kMinImages)
      throw Error(ExitCode::kTooFew,
                  fmt::format("only {} images with {} features or more of one "
                              "board; at least {} are needed, {} are better",
                              images.size(), kMinFeatures, kMinImages, 20));
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

// On to the model asked for: grid, outliers, once more.
void AdjustModel(const Pattern& pattern, const std::string& model,
                 double cell_px, const AdjustmentOptions& options,
                 Adjusted* adjusted) {
  const std::unique_ptr<CameraModel> lens = adjusted->state.camera->Clone();
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
  const Area area = FeatureArea(adjusted->problem);
  if (const auto* camera =
          dynamic_cast<const OpenCvModel*>(adjusted->state.camera.get()))
    adjusted->state.camera = camera->WithArea(area).Clone();
}

void AlignBoards(const Pattern& pattern, Adjusted* adjusted) {
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    std::vector<int> views;
    for (size_t v = 0; v < adjusted->problem.views.size(); ++v)
      if (adjusted->problem.boards[v] == static_cast<int>(b))
        views.push_back(static_cast<int>(v));
    if (!views.empty())
      AlignToNominal(adjusted->problem.first_points[b],
                     pattern.boards[b].points, views, &adjusted->state);
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

// Each view's pose with the camera and the points as they are.
std::vector<std::optional<Pose>> LocalizeViews(const CameraModel& camera,
                                               const Problem& problem,
                                               int num_threads) {
  const int num_views = static_cast<int>(problem.views.size());
  std::vector<std::optional<Pose>> poses(num_views);
  ParallelFor(num_views, NumThreads(num_threads), [&](int v) {
    poses[v] = Localize(camera, MatchesOf(problem.views[v], problem.nominal));
  });
  return poses;
}

// ---- Held-out error --------------------------------------------------------

// Images whose turn it is in a fold are tested, the others trained with.
struct Split {
  Dataset training, test;
};

Split SplitImages(const Dataset& dataset,
                  const std::function<bool(size_t)>& is_test) {
  Split split;
  split.training.image_size = split.test.image_size = dataset.image_size;
  for (size_t i = 0; i < dataset.images.size(); ++i)
    (is_test(i) ? split.test : split.training)
        .images.push_back(dataset.images[i]);
  return split;
}

// Four folds, of which large data need only one.
constexpr size_t kFolds = 4;
int NumFoldsToTry(const Dataset& dataset) {
  if (dataset.images.size() < 2 * kFolds) return 0;
  return dataset.images.size() <= 40 ? kFolds : 1;
}

// Cells as parts of the longer side: coarse enough for a handful of images, and
// as fine as a dense solve is quick.
std::vector<double> CellCandidates(const Dataset& dataset) {
  const double longer =
      std::max(dataset.image_size.width, dataset.image_size.height);
  const double shorter =
      std::min(dataset.image_size.width, dataset.image_size.height);
  std::vector<double> candidates;
  for (const int cells : {4, 8, 16, 24}) {
    const double cell_px = longer / cells;
    const int parameters = 2 * NumControlPoints(longer, cell_px) *
                           NumControlPoints(shorter, cell_px);
    if (candidates.empty() ||
        (parameters < kMaxGridParameters &&
         parameters < 2 * static_cast<int>(dataset.num_features())))
      candidates.push_back(cell_px);
  }
  return candidates;
}

struct Trial {
  double cell_px = 0;
  std::vector<FeatureResidual> held_out;
};

// Held-out residuals for each candidate, over all folds; folds in parallel.
std::vector<Trial> CrossValidate(const Dataset& dataset, const Pattern& pattern,
                                 const CalibrationOptions& options,
                                 const std::vector<double>& cells) {
  const int num_folds = NumFoldsToTry(dataset);
  const int num_cells = static_cast<int>(cells.size());
  AdjustmentOptions serial;
  serial.num_threads = 1;
  serial.fix_points = options.flat_board;

  std::vector<Split> splits;
  std::vector<Adjusted> starts(num_folds);
  for (int fold = 0; fold < num_folds; ++fold)
    splits.push_back(SplitImages(dataset, [fold](size_t i) {
      return i % kFolds == static_cast<size_t>(fold);
    }));
  ParallelFor(num_folds, NumThreads(options.num_threads), [&](int fold) {
    starts[fold] = AdjustStart(splits[fold].training, pattern, serial);
  });

  std::vector<Evaluation> evaluations(num_folds * num_cells);
  int num_done = 0;
  std::mutex mutex;
  ParallelFor(
      num_folds * num_cells, NumThreads(options.num_threads), [&](int i) {
        const int fold = i / num_cells;
        Adjusted adjusted = starts[fold];
        AdjustModel(pattern, options.model, cells[i % num_cells], serial,
                    &adjusted);
        AlignBoards(pattern, &adjusted);
        evaluations[i] =
            EvaluateCamera(*adjusted.state.camera, splits[fold].test,
                           AdjustedPattern(pattern, adjusted), 1);
        const std::lock_guard<std::mutex> lock(mutex);
        if (options.progress)
          options.progress("cross-validation",
                           0.1 + 0.7 * ++num_done / (num_folds * num_cells));
      });

  std::vector<Trial> trials(num_cells);
  for (int i = 0; i < num_folds * num_cells; ++i) {
    Trial& trial = trials[i % num_cells];
    trial.cell_px = cells[i % num_cells];
    trial.held_out.insert(trial.held_out.end(),
                          evaluations[i].residuals.begin(),
                          evaluations[i].residuals.end());
  }
  return trials;
}

CellCandidate Summarize(const Trial& trial) {
  CellCandidate candidate;
  candidate.cell_px = trial.cell_px;
  std::vector<double> norms;
  for (const FeatureResidual& residual : trial.held_out) {
    norms.push_back(residual.error_px.norm());
    candidate.loss +=
        HuberLoss(norms.back(), 1) / static_cast<double>(trial.held_out.size());
  }
  candidate.median_px = Quantile(norms, 0.5);
  if (norms.empty()) candidate.loss = INFINITY;  // nothing could be localised
  return candidate;
}

// The coarsest resolution whose loss is within this part of the best.
constexpr double kAsGoodAs = 0.005;
size_t ChooseCandidate(const std::vector<CellCandidate>& candidates) {
  double best = INFINITY;
  for (const CellCandidate& candidate : candidates)
    best = std::min(best, candidate.loss);
  size_t chosen = 0;
  while (candidates[chosen].loss > (1 + kAsGoodAs) * best) ++chosen;
  return chosen;
}

// ---- The result ------------------------------------------------------------

std::vector<FeatureResidual> TrainingResiduals(const Pattern& pattern,
                                               const Adjusted& adjusted,
                                               int num_threads) {
  const Problem& problem = adjusted.problem;
  const std::vector<Residual> residuals =
      ComputeResiduals(adjusted.state, problem.views, num_threads);
  std::vector<FeatureResidual> result;
  size_t index = 0;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    for (const Observation& observation : problem.views[v].observations) {
      const Residual& residual = residuals[index++];
      if (!residual.valid) continue;
      const Feature feature =
          FeatureOf(problem, pattern, static_cast<int>(v), observation);
      result.push_back({problem.images[v], feature.board, feature.column,
                        feature.row, observation.pixel, residual.error_px});
    }
  }
  return result;
}

Dataset UsedFeatures(const Pattern& pattern, const Problem& problem) {
  Dataset used;
  used.image_size = problem.image_size;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (used.images.empty() || used.images.back().image != problem.images[v])
      used.images.push_back({problem.images[v], {}});
    for (const Observation& observation : problem.views[v].observations)
      used.images.back().features.push_back(
          FeatureOf(problem, pattern, static_cast<int>(v), observation));
  }
  return used;
}

void FillResult(const Pattern& pattern, const CalibrationOptions& options,
                const Adjusted& adjusted, CalibrationResult* result) {
  const Problem& problem = adjusted.problem;
  result->camera.camera = adjusted.state.camera->Clone();
  result->pattern = AdjustedPattern(pattern, adjusted);
  result->features = UsedFeatures(pattern, problem);
  for (size_t v = 0; v < problem.views.size(); ++v)
    result->poses.push_back({problem.images[v],
                             pattern.boards[problem.boards[v]].id,
                             adjusted.state.camera_from_pattern[v]});
  result->training = TrainingResiduals(pattern, adjusted, options.num_threads);
  result->camera.training = ComputeErrorFigures(result->training);
  result->rejected_images = adjusted.rejected_images;
  result->rejected_features = adjusted.rejected_features;
  result->num_parameters = adjusted.state.camera->NumParameters();
  result->converged = adjusted.summary.converged;
  result->bias_kl =
      ComputeBias(result->training, result->camera.camera->area());
}

CalibrationFigures FiguresOf(const CalibrationResult& result) {
  return {result.converged,
          result.camera.camera->image_size(),
          result.camera.camera->area(),
          static_cast<int>(result.features.images.size()),
          static_cast<int>(result.rejected_images.size()),
          *result.camera.training,
          result.camera.held_out};
}

// ---- Features measured again -----------------------------------------------

// Both have the same features.
double RmsMovePx(const Dataset& before, const Dataset& after) {
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

// Through a first camera of medium resolution: what bends the mapping within a
// window is mostly the lens's distortion.
Dataset MeasureFeaturesAgain(const Dataset& dataset, const Pattern& pattern,
                             const CalibrationOptions& options,
                             const AdjustmentOptions& adjustment,
                             Adjusted first) {
  constexpr size_t kMediumCandidate = 2;
  const std::vector<double> cells = CellCandidates(dataset);
  const double cell_px =
      options.cell_px > 0 ? options.cell_px
                          : cells[std::min(kMediumCandidate, cells.size() - 1)];
  AdjustModel(pattern, options.model, cell_px, adjustment, &first);
  AlignBoards(pattern, &first);
  const Pattern adjusted_pattern = AdjustedPattern(pattern, first);
  std::vector<RejectedImage> rejected;
  const Problem problem = BuildProblem(dataset, adjusted_pattern, &rejected);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(*first.state.camera, problem, adjustment.num_threads);
  std::vector<BoardPose> known;
  for (size_t v = 0; v < poses.size(); ++v)
    if (poses[v])
      known.push_back(
          {problem.images[v], pattern.boards[problem.boards[v]].id, *poses[v]});
  return options.measure_again(*first.state.camera, adjusted_pattern, known);
}

void RequireKnownModel(const std::string& model) {
  if (model != "central-generic" && model != "opencv")
    throw Error(ExitCode::kUsage,
                fmt::format("unknown model '{}'; this version calibrates "
                            "central-generic and opencv",
                            model));
}

void RequireHeldOutImagesExist(const Dataset& dataset,
                               const std::vector<std::string>& hold_out) {
  for (const std::string& name : hold_out)
    if (std::none_of(dataset.images.begin(), dataset.images.end(),
                     [&](const auto& image) { return image.image == name; }))
      throw Error(
          ExitCode::kUsage,
          fmt::format("--hold-out {}: no features of such an image", name));
}

}  // namespace

Evaluation EvaluateCamera(const CameraModel& camera, const Dataset& dataset,
                          const Pattern& pattern, int num_threads) {
  Evaluation evaluation;
  const Problem problem =
      BuildProblem(dataset, pattern, &evaluation.rejected_images);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(camera, problem, num_threads);
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (!poses[v]) {
      evaluation.rejected_images.push_back(
          {problem.images[v], "could not be localised"});
      continue;
    }
    for (const Observation& observation : problem.views[v].observations) {
      const auto pixel =
          camera.Project(*poses[v] * problem.nominal[observation.point],
                         &observation.pixel, kAdjustmentMarginPx);
      if (!camera.area().Contains(observation.pixel) || !pixel) {
        ++evaluation.outside_area;
        continue;
      }
      const Feature feature = FeatureOf(problem, pattern, v, observation);
      evaluation.residuals.push_back(
          {problem.images[v], feature.board, feature.column, feature.row,
           observation.pixel, *pixel - observation.pixel});
    }
  }
  return evaluation;
}

CalibrationResult Calibrate(const Dataset& measured, const Pattern& pattern,
                            const CalibrationOptions& options) {
  RequireKnownModel(options.model);
  RequireHeldOutImagesExist(measured, options.hold_out);
  const auto report = [&options](const std::string& stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  const auto split_images = [&options](const Dataset& dataset) {
    return SplitImages(dataset, [&](size_t i) {
      return std::count(options.hold_out.begin(), options.hold_out.end(),
                        dataset.images[i].image) > 0;
    });
  };
  Split split = split_images(measured);
  AdjustmentOptions adjustment;
  adjustment.num_threads = NumThreads(options.num_threads);
  adjustment.fix_points = options.flat_board;
  CalibrationResult result;

  report("start", 0);
  const Stopwatch start_time;
  Adjusted adjusted = AdjustStart(split.training, pattern, adjustment);
  result.seconds["start"] = start_time.Seconds();

  if (options.measure_again) {
    report("measuring again", 0.05);
    const Stopwatch again_time;
    const Dataset again =
        MeasureFeaturesAgain(measured, pattern, options, adjustment, adjusted);
    result.measured_again_rms_px = RmsMovePx(measured, again);
    split = split_images(again);
    adjusted = AdjustStart(split.training, pattern, adjustment);
    result.seconds["measuring_again"] = again_time.Seconds();
  }

  const bool is_grid = options.model != "opencv";
  const bool choose_cell = is_grid && options.cell_px <= 0;
  const std::vector<double> cells = choose_cell
                                        ? CellCandidates(split.training)
                                        : std::vector<double>{options.cell_px};
  result.cell_px = is_grid ? cells.front() : 0;
  const Stopwatch validation_time;
  report("cross-validation", 0.1);
  if (NumFoldsToTry(split.training) > 0 &&
      (choose_cell || options.hold_out.empty())) {
    const std::vector<Trial> trials =
        CrossValidate(split.training, pattern, options, cells);
    for (const Trial& trial : trials)
      result.cell_candidates.push_back(Summarize(trial));
    const size_t chosen = ChooseCandidate(result.cell_candidates);
    if (is_grid) result.cell_px = cells[chosen];
    result.held_out = trials[chosen].held_out;
    result.cross_validated = true;
    if (!is_grid) result.cell_candidates.clear();
  }
  result.seconds["cross_validation"] = validation_time.Seconds();

  report("bundle adjustment", 0.8);
  const Stopwatch adjustment_time;
  AdjustModel(pattern, options.model, result.cell_px, adjustment, &adjusted);
  AlignBoards(pattern, &adjusted);
  FillResult(pattern, options, adjusted, &result);
  result.seconds["adjustment"] = adjustment_time.Seconds();

  if (!options.hold_out.empty()) {
    result.held_out = EvaluateCamera(*result.camera.camera, split.test,
                                     result.pattern, options.num_threads)
                          .residuals;
    result.cross_validated = false;
  }
  if (!result.held_out.empty())
    result.camera.held_out = ComputeErrorFigures(result.held_out);
  result.verdict = JudgeCalibration(FiguresOf(result));
  report("done", 1);
  return result;
}

}  // namespace raygrid
