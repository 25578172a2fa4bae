#include "calibration/parametric_comparison.h"

#include <algorithm>

#include "calibration/camera_result.h"
#include "calibration/grid_choice.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

ModelFigures Measure(const CameraInProgress& camera, const Pattern& pattern,
                     const CalibrationOptions& options,
                     const std::string& model, double cell_px) {
  Adjusted adjusted = camera.lens;
  AdjustmentOptions adjustment = StoppableAdjustment(options);
  adjustment.rigid_boards = !camera.boards_bend;
  AdjustModel(pattern, model, {cell_px}, adjustment, &adjusted);
  AlignBoards(pattern, &adjusted);
  CalibrationResult result;
  FillResult(pattern, adjusted, 0, camera.input->image_circle,
             options.num_threads, &result);
  ModelFigures figures;
  figures.model = model;
  figures.num_parameters = result.num_parameters;
  figures.training = *result.camera.training;
  figures.bias_kl = result.bias_kl;
  ValidationOptions validation = ValidationOptionsOf(options);
  validation.model = model;
  validation.rigid_boards = adjustment.rigid_boards;
  std::vector<Trial> trials;
  HeldOut held_out = EvaluateHeldOut(adjusted, pattern, {camera.split},
                                     validation, {cell_px}, &trials);
  if (held_out.alone.empty() || held_out.alone.front().empty()) return figures;
  if (!held_out.flexed.front().empty())
    figures.held_out_flexed = ComputeErrorFigures(held_out.flexed.front());
  figures.held_out_residuals = std::move(held_out.alone.front());
  figures.held_out = ComputeErrorFigures(figures.held_out_residuals);
  return figures;
}

}  // namespace

std::vector<ModelFigures> CompareParametricModels(
    const CameraInProgress& camera, const Pattern& pattern,
    const CalibrationOptions& options) {
  std::vector<ModelFigures> models;
  for (const char* model : {"opencv", "thin-prism-fisheye", "central-radial"}) {
    if (model == options.model || options.ShouldStop()) continue;
    try {
      ModelFigures figures = Measure(camera, pattern, options, model, 0);
      if (!options.ShouldStop()) models.push_back(std::move(figures));
    } catch (const Error&) {
      // A fisheye may be beyond what a model can say.
    }
  }
  return models;
}

std::optional<ModelFigures> TryAnotherGrid(const CameraInProgress& camera,
                                           const Pattern& pattern,
                                           const CalibrationOptions& options) {
  if (options.model == "noncentral-generic") return std::nullopt;
  const std::string model = options.model == "central-generic"
                                ? "noncentral-generic"
                                : "central-generic";
  const Dataset& training = camera.split.training;
  double cell_px = camera.result.cell_px;
  if (cell_px <= 0) cell_px = MediumCellPx(training, model);
  cell_px = std::max(cell_px, CellCandidates(training, model).back());
  try {
    return Measure(camera, pattern, options, model, cell_px);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace raygrid
