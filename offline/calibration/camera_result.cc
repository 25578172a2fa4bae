#include "calibration/camera_result.h"

#include "calibration/camera_trust.h"

namespace raygrid {
namespace {

std::vector<FeatureResidual> TrainingResiduals(const Pattern& pattern,
                                               const Adjusted& adjusted,
                                               int camera, int num_threads) {
  const CalibrationProblem& problem = adjusted.problem;
  const std::vector<Residual> residuals =
      ComputeResiduals(adjusted.state, problem.views, num_threads);
  std::vector<FeatureResidual> result;
  size_t index = 0;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    for (const Observation& observation : problem.views[v].observations) {
      const Residual& residual = residuals[index++];
      if (!residual.valid || problem.views[v].camera != camera) continue;
      const Feature feature =
          problem.FeatureOf(pattern, static_cast<int>(v), observation);
      result.push_back({problem.images[v], feature.board, feature.column,
                        feature.row, observation.pixel, residual.error_px});
    }
  }
  return result;
}

Dataset UsedFeatures(const Pattern& pattern, const CalibrationProblem& problem,
                     int camera) {
  Dataset used;
  used.image_size = problem.image_sizes[camera];
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != camera) continue;
    if (used.images.empty() || used.images.back().image != problem.images[v])
      used.images.push_back({problem.images[v], {}});
    for (const Observation& observation : problem.views[v].observations)
      used.images.back().features.push_back(
          problem.FeatureOf(pattern, static_cast<int>(v), observation));
  }
  return used;
}

CalibrationFigures FiguresOf(const CalibrationResult& result) {
  return {result.converged,
          result.checkpoint.has_value(),
          result.camera.camera->image_size(),
          result.camera.camera->area(),
          static_cast<int>(result.features.images.size()),
          static_cast<int>(result.rejected_images.size()),
          *result.camera.training,
          result.camera.held_out,
          result.neighbor_correlation};
}

}  // namespace

void FillResult(const Pattern& pattern, const Adjusted& adjusted, int camera,
                int num_threads, CalibrationResult* result) {
  const CalibrationProblem& problem = adjusted.problem;
  result->camera.camera = adjusted.state.cameras[camera]->Clone();
  result->pattern = AdjustedPattern(pattern, adjusted);
  result->features = UsedFeatures(pattern, problem, camera);
  for (size_t v = 0; v < problem.views.size(); ++v)
    if (problem.views[v].camera == camera)
      result->poses.push_back(
          {problem.images[v], pattern.boards[problem.boards[v]].id,
           adjusted.state.CameraFromPattern(problem.views[v])});
  result->training = TrainingResiduals(pattern, adjusted, camera, num_threads);
  result->camera.training = ComputeErrorFigures(result->training);
  result->camera.uncertainty = UncertaintyOf(adjusted, camera, num_threads);
  result->rejected_features = adjusted.rejected_features[camera];
  result->num_parameters = adjusted.state.cameras[camera]->NumParameters();
  result->converged = adjusted.summary.converged;
  result->bias_kl =
      ComputeBias(result->training, result->camera.camera->area());
  result->noise_bias_kl =
      NoiseBias(result->training, result->camera.camera->area());
  if (!result->camera.camera->IsCentral())
    result->line_spread = MeasureLineSpread(*result->camera.camera);
}

void JudgeResult(CalibrationResult* result) {
  if (!result->held_out.empty())
    result->camera.held_out = ComputeErrorFigures(result->held_out);
  result->neighbor_correlation = NeighborCorrelation(
      result->held_out.empty() ? result->training : result->held_out);
  result->verdict = JudgeCalibration(FiguresOf(*result));
}

}  // namespace raygrid
