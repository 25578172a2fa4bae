#include <fmt/format.h>

#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "evaluation/model_difference.h"
#include "experiments/calibrated_cameras.h"
#include "experiments/montage.h"
#include "report/plots.h"

namespace raygrid {
namespace {

// Returns the user's camera, or a camera calibrated from features.
std::shared_ptr<const CameraModel> GenericCamera(
    const ExperimentOptions& options, std::vector<Condition>* conditions) {
  constexpr int kCells = 16;
  if (!options.data.cameras.empty()) {
    const NamedCamera& camera = options.data.cameras.front();
    conditions->push_back({"camera", "user-provided, " + camera.model->Name()});
    return camera.model;
  }
  const ExperimentFeatures features = SelectFeatures(options);
  *conditions = features.conditions;
  const ModelChoice choice = {models::kCentralGeneric, kCells};
  conditions->push_back({"camera", choice.Label() + ", calibrated"});
  return CalibrateModel(features, choice, options).camera.camera;
}

std::vector<FeatureResidual> Places(const ModelDifference& difference) {
  std::vector<FeatureResidual> places;
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    FeatureResidual place;
    place.pixel = difference.pixels[i];
    place.error_px = difference.error_px[i];
    places.push_back(place);
  }
  return places;
}

}  // namespace

ExperimentResult CompareModelsByFit(const ExperimentOptions& options) {
  ExperimentResult table;
  const auto camera = GenericCamera(options, &table.conditions);
  table.columns = {"model",  "parameters", "median_px",   "rms_px",
                   "p99_px", "max_px",     "rotation_rad"};
  table.chart.title = "Fit error of parametric models to a generic camera";
  table.chart.note = "all pixels, after rotational alignment";
  table.chart.x_label = "model";
  table.chart.y_label = "difference, px";
  ChartSeries median = {"median", {}, false}, rms = {"RMS", {}, false},
              p99 = {"99 % below", {}, false};
  std::vector<MontageImage> directions, magnitudes;
  const double step_px = std::max(
      1.0, std::max(camera->area().width(), camera->area().height()) / 160);
  double full_scale_px = 0;
  std::vector<ModelDifference> differences;
  std::vector<std::string> names;
  for (const std::string& name : ListModelNames(ModelUse::kCompare)) {
    const FittedModel fitted =
        FitParametricModel(name, *camera, camera->area(), {true});
    differences.push_back(CompareModels(*camera, *fitted.model, step_px));
    const ModelDifference& d = differences.back();
    if (d.pixels.empty()) {
      differences.pop_back();
      table.conditions.push_back({name, "cannot represent this camera"});
      continue;
    }
    names.push_back(name);
    const double place = static_cast<double>(table.chart.ticks.size());
    table.rows.push_back({name, fitted.model->NumParameters(), d.median_px,
                          d.rms_px, d.p99_px, d.max_px,
                          fitted.model_from_camera.angularDistance(
                              Eigen::Quaterniond::Identity())});
    table.chart.ticks.push_back({place, name});
    median.points.push_back({place, d.median_px});
    rms.points.push_back({place, d.rms_px});
    p99.points.push_back({place, d.p99_px});
    full_scale_px = std::max(full_scale_px, d.p99_px);
  }
  if (differences.empty())
    throw Error(ExitCode::kInitializationFailed, "no model could be fitted");
  for (size_t i = 0; i < differences.size(); ++i) {
    const ModelDifference& d = differences[i];
    const auto places = Places(d);
    magnitudes.push_back({fmt::format("{}: RMS {:.3f} px", names[i], d.rms_px),
                          DrawMagnitudePlot(places, camera->image_size(),
                                            camera->area(), full_scale_px)});
    directions.push_back(
        {names[i],
         DrawDirectionPlot(places, camera->image_size(), camera->area())});
  }
  const Image wheel = DrawDirectionLegend(96),
              bar = DrawColorLegend(ColorScale::kMagnitude, "0",
                                    fmt::format("{:.3g} px +", full_scale_px));
  table.pictures = {
      {"magnitude",
       ComposeMontage(magnitudes,
                      {"Pixel distance between rays of the generic camera",
                       "projected by the fitted model and their pixels."},
                      &bar)},
      {"direction", ComposeMontage(directions,
                                   {"Direction of the difference, by the",
                                    "colours of the wheel."},
                                   &wheel)}};
  table.chart.series = {median, rms, p99};
  return table;
}

}  // namespace raygrid
