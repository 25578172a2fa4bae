#include "calibration/parametric_comparison.h"

#include "calibration/camera_evaluation.h"
#include "calibration/camera_result.h"
#include "calibration/camera_start.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

std::vector<FeatureResidual> HeldOut(const Split& split, const Pattern& pattern,
                                     const CalibrationOptions& options,
                                     const std::string& model,
                                     const CalibrationResult& result) {
  if (!split.test.images.empty())
    return EvaluateCamera(*result.camera.camera, split.test, result.pattern,
                          options.num_threads)
        .residuals;
  const int num_folds = NumFoldsToTry(split.training);
  if (num_folds == 0) return {};
  std::vector<Checkpoint::Trial> done;
  CrossValidate(split.training, pattern,
                {model,
                 options.flat_board,
                 options.num_threads,
                 {},
                 options.should_stop,
                 {}},
                {0}, &done);
  const std::vector<Trial> trials = JoinFolds(done, num_folds, {0});
  return trials.empty() ? std::vector<FeatureResidual>()
                        : trials.front().held_out;
}

ModelFigures Measure(const Split& split, const Pattern& pattern,
                     const CalibrationOptions& options,
                     const std::string& model, Adjusted adjusted) {
  AdjustmentOptions adjustment = AdjustmentOptionsOf(options);
  adjustment.should_stop = options.should_stop;
  AdjustModel(pattern, model, {0}, adjustment, &adjusted);
  AlignBoards(pattern, &adjusted);
  CalibrationResult result;
  FillResult(pattern, adjusted, 0, options.num_threads, &result);
  ModelFigures figures;
  figures.model = model;
  figures.num_parameters = result.num_parameters;
  figures.training = *result.camera.training;
  figures.bias_kl = result.bias_kl;
  const std::vector<FeatureResidual> held_out =
      HeldOut(split, pattern, options, model, result);
  if (!held_out.empty()) figures.held_out = ComputeErrorFigures(held_out);
  return figures;
}

}  // namespace

std::vector<ModelFigures> CompareParametricModels(
    const Split& split, const Pattern& pattern,
    const CalibrationOptions& options, const Adjusted& start) {
  std::vector<ModelFigures> models;
  for (const char* model : {"opencv", "thin-prism-fisheye", "central-radial"}) {
    if (model == options.model || ShouldStop(options)) continue;
    try {
      ModelFigures figures = Measure(split, pattern, options, model, start);
      if (!ShouldStop(options)) models.push_back(std::move(figures));
    } catch (const Error&) {
      // A fisheye may be beyond what a model can say.
    }
  }
  return models;
}

}  // namespace raygrid
