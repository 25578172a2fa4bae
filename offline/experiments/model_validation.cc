#include <fmt/format.h>

#include "dataset/error.h"
#include "evaluation/model_difference.h"
#include "experiments/calibrated_cameras.h"
#include "experiments/fine_validation.h"
#include "experiments/montage.h"
#include "report/plots.h"

namespace raygrid {
namespace {

std::vector<ModelChoice> ValidatedModels() {
  std::vector<ModelChoice> choices;
  for (const std::string& name : ListModelNames(ModelUse::kCompare))
    choices.push_back({name});
  for (const int cells : {8, 16, 24})
    choices.push_back({models::kCentralGeneric, cells});
  choices.push_back({models::kNonCentralGeneric, 16});
  return choices;
}

// Returns the median error of the rays after the best-fit rotation; empty
// without ground truth.
Cell RayError(const ExperimentFeatures& features,
              const CalibrationResult& result) {
  constexpr double kStepPx = 8;
  if (!features.truth) return std::string("-");
  return CompareModels(*features.truth, *result.camera.camera, kStepPx)
      .median_px;
}

// The bias is unknown if no cell has enough features.
Cell NumberOrDash(const std::optional<double>& number) {
  if (number) return *number;
  return std::string("-");
}

std::string ShortLabel(const ModelChoice& choice) {
  const size_t generic = choice.model.find("-generic");
  return generic == std::string::npos
             ? choice.model
             : fmt::format("{}/{}", choice.model.substr(0, generic),
                           choice.cells);
}

struct ErrorSeries {
  ChartSeries training = {"training", {}, false};
  ChartSeries test = {"test", {}, false};
};

void AddValidationRow(const ExperimentFeatures& features,
                      const ModelChoice& choice,
                      const CalibrationResult& result, ExperimentResult* table,
                      ErrorSeries* series) {
  const double place = static_cast<double>(table->chart.ticks.size());
  table->rows.push_back(
      {choice.model, choice.cells, result.num_parameters,
       result.camera.training->median_px, result.camera.held_out->median_px,
       result.bias_kl.value_or(0), NumberOrDash(result.noise_bias_kl),
       RayError(features, result)});
  table->chart.ticks.push_back({place, ShortLabel(choice)});
  series->training.points.push_back({place, result.camera.training->median_px});
  series->test.points.push_back({place, result.camera.held_out->median_px});
}

MontageImage Directions(const ModelChoice& choice,
                        const CalibrationResult& result) {
  const CameraModel& camera = *result.camera.camera;
  return {
      fmt::format("{}: test {:.3g} px, bias {:.3f}", choice.Label(),
                  result.camera.held_out->median_px,
                  result.bias_kl.value_or(0)),
      DrawDirectionPlot(result.training, camera.image_size(), camera.area())};
}

}  // namespace

ExperimentResult ValidateModels(const ExperimentOptions& options) {
  if (options.fine) return ValidateFineModels(options);
  const ExperimentFeatures features = SelectFeatures(options);
  ExperimentResult table;
  table.conditions = features.conditions;
  table.columns = {
      "model",          "cells",   "parameters",    "training_median_px",
      "test_median_px", "bias_kl", "noise_bias_kl", "ray_error_px"};
  table.chart.title = "Reprojection error by model";
  table.chart.note =
      "median over features; after the slash: knots of the generic models "
      "along the longer side";
  table.chart.x_label = "model";
  table.chart.y_label = "median error, px";
  table.chart.is_logarithmic = true;
  ErrorSeries series;
  std::vector<MontageImage> pictures;
  const std::vector<ModelChoice> choices = ValidatedModels();
  const size_t count = choices.size();
  for (size_t i = 0; i < count; ++i) {
    const ModelChoice& choice = choices[i];
    try {
      const CalibrationResult result =
          CalibrateModel(features, choice, options);
      AddValidationRow(features, choice, result, &table, &series);
      pictures.push_back(Directions(choice, result));
    } catch (const Error& error) {
      table.conditions.push_back({choice.Label(), error.what()});
    }
    if (options.progress) options.progress(double(i + 1) / double(count));
  }
  if (pictures.empty())
    throw Error(ExitCode::kInitializationFailed,
                "no model could be calibrated");
  table.chart.series = {series.training, series.test};
  const Image wheel = DrawDirectionLegend(96);
  table.pictures.push_back(
      {"directions",
       ComposeMontage(pictures,
                      {"Direction of the nearest training residual",
                       "(projected - observed), by the colours of the wheel.",
                       "Patches of one colour: model error, not noise."},
                      &wheel)});
  return table;
}

}  // namespace raygrid
