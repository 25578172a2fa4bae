#include "calibration/parametric_comparison.h"

#include <algorithm>

#include "calibration/camera_evaluation.h"
#include "calibration/camera_preparation.h"
#include "calibration/camera_result.h"
#include "calibration/grid_choice.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

std::vector<FeatureResidual> HeldOutResiduals(const Split& split,
                                              const Pattern& pattern,
                                              const CalibrationOptions& options,
                                              const std::string& model,
                                              double cell_px,
                                              const CalibrationResult& result) {
  if (!split.test.images.empty())
    return EvaluateCamera(*result.camera.camera, split.test, result.pattern,
                          options.num_threads)
        .residuals;
  std::vector<Trial> done;
  CrossValidate({split}, pattern,
                {model,
                 options.flat_board,
                 options.num_threads,
                 {},
                 options.should_stop,
                 {}},
                {{cell_px}}, &done);
  HeldOut joined = JoinFolds(done, NumFoldsToTry({split}), {cell_px});
  return joined.alone.empty() ? std::vector<FeatureResidual>()
                              : std::move(joined.alone.front());
}

ModelFigures Measure(const Split& split, const Pattern& pattern,
                     const CalibrationOptions& options,
                     const std::string& model, double cell_px,
                     Adjusted adjusted) {
  AdjustmentOptions adjustment = AdjustmentOptionsOf(options);
  adjustment.should_stop = options.should_stop;
  AdjustModel(pattern, model, {cell_px}, adjustment, &adjusted);
  AlignBoards(pattern, &adjusted);
  CalibrationResult result;
  FillResult(pattern, adjusted, 0, options.num_threads, &result);
  ModelFigures figures;
  figures.model = model;
  figures.num_parameters = result.num_parameters;
  figures.training = *result.camera.training;
  figures.bias_kl = result.bias_kl;
  figures.held_out_residuals =
      HeldOutResiduals(split, pattern, options, model, cell_px, result);
  if (!figures.held_out_residuals.empty())
    figures.held_out = ComputeErrorFigures(figures.held_out_residuals);
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
      ModelFigures figures = Measure(split, pattern, options, model, 0, start);
      if (!ShouldStop(options)) models.push_back(std::move(figures));
    } catch (const Error&) {
      // A fisheye may be beyond what a model can say.
    }
  }
  return models;
}

std::optional<ModelFigures> TryAnotherGrid(const Split& split,
                                           const Pattern& pattern,
                                           const CalibrationOptions& options,
                                           const Adjusted& start,
                                           double cell_px) {
  if (options.model == "noncentral-generic") return std::nullopt;
  const std::string model = options.model == "central-generic"
                                ? "noncentral-generic"
                                : "central-generic";
  constexpr size_t kMediumCandidate = 2;  // where there are no cells yet
  const std::vector<double> cells = CellCandidates(split.training, model);
  const size_t medium = std::min(kMediumCandidate, cells.size() - 1);
  if (cell_px <= 0) cell_px = cells[medium];
  try {
    return Measure(split, pattern, options, model,
                   std::max(cell_px, cells.back()), start);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace raygrid
