#include "calibration/parametric_comparison.h"

#include <algorithm>
#include <cmath>

#include "calibration/camera_result.h"
#include "calibration/knot_spacing_search.h"
#include "calibration/knot_spacing_selection.h"
#include "camera/model_registry.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

using ConcurrentTask = std::function<void(int num_threads)>;

struct Candidate {
  std::string model;
  double knot_spacing_px = 0;  // for grids
};

// Evaluation of a model.
struct ModelEvaluation {
  Candidate candidate;
  ModelMetrics metrics;  // metrics over all training images
  HeldOutResiduals held_out;
  // Models without a wide field of view may fail on a fisheye.
  bool is_done = false;
};

void MeasureTraining(const CameraInProgress& camera, const Pattern& pattern,
                     const ValidationOptions& validation,
                     const AdjustmentOptions& options, Folds* folds,
                     ModelEvaluation* measurement) {
  const std::vector<double> knot_spacings_px = {
      measurement->candidate.knot_spacing_px};
  AdjustmentResult adjusted = camera.lens;
  if (folds->whole)
    adjusted = OptimizeWholeModel(pattern, validation.model,
                                  knot_spacings_px.front(), options, folds);
  else
    OptimizeModel(pattern, validation.model, knot_spacings_px, options,
                  &adjusted);
  AlignBoards(pattern, &adjusted);
  const std::vector<FeatureResidual> training =
      ComputeTrainingResiduals(pattern, adjusted, 0, options.num_threads);
  const CameraModel& model = adjusted.state.camera();
  // Uses the given test images if any, and cross-validation otherwise.
  if (!camera.split.test.images.empty())
    measurement->held_out =
        EvaluateHeldOut(adjusted, pattern, {camera.split}, validation,
                        knot_spacings_px, nullptr, nullptr);
  ModelMetrics& metrics = measurement->metrics;
  metrics.model = validation.model;
  metrics.num_parameters = model.NumParameters();
  metrics.training = ComputeErrorMetrics(training);
  metrics.bias_kl = ComputeBias(training, model.area());
}

void MeasureHeldOut(const CameraInProgress& camera, const Pattern& pattern,
                    const ValidationOptions& validation,
                    const ModelTrials& done, Folds* folds,
                    ModelEvaluation* measurement) {
  if (!camera.split.test.images.empty()) return;
  const std::vector<double> knot_spacings_px = {
      measurement->candidate.knot_spacing_px};
  std::vector<Trial> trials;
  if (const auto known = done.find(validation.model); known != done.end())
    trials = known->second;
  CrossValidate(pattern, validation, {knot_spacings_px}, folds, &trials);
  measurement->held_out = JoinFolds(trials, folds->count(), knot_spacings_px,
                                    validation.rigid_boards);
}

ModelMetrics ComputeModelMetrics(ModelEvaluation measurement) {
  ModelMetrics metrics = std::move(measurement.metrics);
  HeldOutResiduals& held_out = measurement.held_out;
  if (held_out.alone.empty() || held_out.alone.front().empty()) return metrics;
  if (!held_out.with_deformation.front().empty())
    metrics.held_out_deformed =
        ComputeErrorMetrics(held_out.with_deformation.front());
  metrics.held_out_residuals = std::move(held_out.alone.front());
  metrics.held_out = ComputeErrorMetrics(metrics.held_out_residuals);
  return metrics;
}

std::vector<ModelMetrics> Measure(const std::vector<Candidate>& candidates,
                                  const CameraInProgress& camera,
                                  const Pattern& pattern,
                                  const CalibrationOptions& options,
                                  const ModelTrials& done,
                                  const ConcurrentTask& beside) {
  std::vector<ModelEvaluation> measurements;
  for (const Candidate& candidate : candidates)
    measurements.push_back({candidate, {}, {}});
  const int num_threads = NumThreads(options.num_threads);
  const int num_models = static_cast<int>(candidates.size());
  AdjustmentOptions adjustment = MakeStoppableOptions(options);
  adjustment.rigid_boards = !camera.per_view_deformation;
  adjustment.num_threads = std::max(1, num_threads / num_models);
  const int num_extra_tasks = beside ? 1 : 0;
  ParallelFor(num_extra_tasks + num_models, num_threads, [&](int i) {
    if (i < num_extra_tasks) return beside(std::max(1, num_threads / 2));
    // The last models have the most parameters; starting the slowest ones first
    // balances the load.
    ModelEvaluation& measurement =
        measurements[num_models - 1 - (i - num_extra_tasks)];
    ValidationOptions validation = MakeValidationOptions(options);
    validation.model = measurement.candidate.model;
    validation.rigid_boards =
        adjustment.rigid_boards || IsParametricModel(validation.model);
    validation.num_threads = adjustment.num_threads;
    try {
      Folds folds = camera.folds;  // copied for each model
      MeasureTraining(camera, pattern, validation, adjustment, &folds,
                      &measurement);
      MeasureHeldOut(camera, pattern, validation, done, &folds, &measurement);
      measurement.is_done = true;
    } catch (const Error&) {
    }
  });
  std::vector<ModelMetrics> metrics;
  if (options.ShouldStop()) return metrics;
  for (ModelEvaluation& measurement : measurements)
    if (measurement.is_done)
      metrics.push_back(ComputeModelMetrics(std::move(measurement)));
  return metrics;
}

}  // namespace

std::vector<ModelMetrics> CompareParametricModels(
    const CameraInProgress& camera, const Pattern& pattern,
    const CalibrationOptions& options, const ModelTrials& done,
    const ConcurrentTask& beside) {
  std::vector<Candidate> candidates;
  for (const std::string& model : ListModelNames(ModelUse::kCompare))
    if (model != options.model) candidates.push_back({model});
  if (IsParametricModel(options.model) && camera.grid_knot_spacing_px > 0)
    candidates.push_back(
        {models::kCentralGeneric, camera.grid_knot_spacing_px});
  return Measure(candidates, camera, pattern, options, done, beside);
}

std::optional<double> EstimateModelErrorPx(const CalibrationResult& result) {
  constexpr double kMinSigmas = 2;
  const std::string own = result.camera.camera->Name();
  std::optional<double> error_px;
  if (result.held_out.empty()) return error_px;
  const double current_error_px =
      ComputeErrorMetrics(result.held_out).median_px;
  for (const ModelMetrics& other : result.parametric_models) {
    const bool has_more_parameters =
        (other.model == models::kNonCentralGeneric && own != other.model) ||
        (other.model == models::kCentralGeneric && IsParametricModel(own));
    if (!has_more_parameters || !other.held_out ||
        other.held_out->median_px >= current_error_px ||
        ComputeLossZScore(result.held_out, other.held_out_residuals,
                          current_error_px) < kMinSigmas)
      continue;
    const double other_px = other.held_out->median_px;
    error_px = std::max(
        error_px.value_or(0),
        std::sqrt(current_error_px * current_error_px - other_px * other_px));
  }
  return error_px;
}

std::optional<ModelMetrics> CompareAlternativeGrid(
    const CameraInProgress& camera, const Pattern& pattern,
    const CalibrationOptions& options, const ModelTrials& done) {
  if (options.model == models::kNonCentralGeneric) return std::nullopt;
  const std::string model = options.model == models::kCentralGeneric
                                ? models::kNonCentralGeneric
                                : models::kCentralGeneric;
  const Dataset& training = camera.split.training;
  double knot_spacing_px = camera.result.knot_spacing_px;
  knot_spacing_px =
      std::max(knot_spacing_px, MediumKnotSpacingPx(training, model));
  const std::vector<ModelMetrics> metrics =
      Measure({{model, knot_spacing_px}}, camera, pattern, options, done, {});
  if (metrics.empty()) return std::nullopt;
  return metrics.front();
}

}  // namespace raygrid
