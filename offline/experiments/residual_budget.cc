#include "evaluation/residual_budget.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "calibration/budget_input.h"
#include "dataset/error.h"
#include "evaluation/budget_assessment.h"
#include "experiments/experiment.h"
#include "simulation/faulty_observations.h"
#include "simulation/simulated_camera_models.h"

namespace raygrid {
namespace {

double ToPercent(double part) { return std::round(1e4 * part) / 100; }

void AddVerdict(const ResidualBudget& budget, const std::string& prefix,
                ExperimentResult* table) {
  const BudgetAssessment assessment = AssessBudget(budget);
  table->conditions.push_back({prefix + "limited by", assessment.sentence});
  table->conditions.push_back({prefix + "to do", assessment.advice});
}

// ---- A user's calibration ---------------------------------------------------

void AddShare(const std::string& name, double part, ExperimentResult* table) {
  table->rows.push_back({name, ToPercent(part), std::string("-"),
                         std::string("-"), std::string("")});
}

void AddCauseRow(ErrorCause cause, const CauseShare& share,
                 ExperimentResult* table) {
  if (!share.is_observable) {
    table->rows.push_back({std::string(ToString(cause)), 0.0, std::string("-"),
                           std::string("-"),
                           "not observable: " + share.unobservable_reason});
    return;
  }
  table->rows.push_back(
      {std::string(ToString(cause)), ToPercent(share.sequential_share),
       fmt::format("{:.2f}", 100 * share.alone),
       fmt::format("{:.2f}", 100 * share.random_limit),
       std::string(share.is_indistinguishable
                       ? "indistinguishable from the largest"
                   : share.IsDetermined() ? "significant"
                                          : "not significant")});
}

Chart MakeBudgetChart(const ResidualBudget& budget) {
  Chart chart;
  chart.title = "Residual budget";
  chart.note =
      fmt::format("{} features in {} views, RMS {:.3g} px per axis",
                  budget.num_features, budget.num_views, budget.rms_px);
  chart.x_label = "cause";
  chart.y_label = "fraction of the squared residuals, %";
  ChartSeries parts = {"part", {}, false}, alone = {"alone", {}, false},
              chance = {"chance level (upper bound)", {}, false};
  const auto tick = [&chart](const std::string& name) {
    chart.ticks.push_back({static_cast<double>(chart.ticks.size()), name});
    return chart.ticks.back().x;
  };
  const auto percent = [](double part) { return 100 * std::max(part, 0.0); };
  parts.points.push_back({tick("noise"), percent(budget.noise)});
  parts.points.push_back({tick("outliers"), percent(budget.large)});
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const auto cause = static_cast<ErrorCause>(k);
    const CauseShare& share = budget.Of(cause);
    const double x = tick(ToString(cause));
    if (!share.is_observable) continue;
    parts.points.push_back({x, percent(share.sequential_share)});
    alone.points.push_back({x, percent(share.alone)});
    chance.points.push_back({x, percent(share.random_limit)});
  }
  parts.points.push_back({tick("unexplained"), percent(budget.rest)});
  chart.series = {alone, chance, parts};  // the last is drawn on top
  return chart;
}

BudgetInput MakeUserInput(const ExperimentData& data, int num_threads) {
  if (data.result && (data.features || !data.cameras.empty()))
    throw Error(ExitCode::kUsage,
                "residual-budget: --result includes features and a camera; "
                "omit --features and --camera");
  if (data.result) {
    if (!data.result->budget)
      throw InputError(
          "--result: interrupted, or written by another version of raygrid; "
          "rerun the calibration");
    return MakeBudgetInput(*data.result, data.result->budget->facts);
  }
  if (!data.features || data.cameras.size() != 1)
    throw Error(ExitCode::kUsage,
                "residual-budget: specify one --result folder, or --features, "
                "--pattern, --image-size and one --camera");
  const CameraModel& camera = *data.cameras.front().model;
  if (camera.image_size() != data.features->image_size)
    throw InputError(data.cameras.front().name +
                     ": its image size differs from --image-size");
  return MakeBudgetInput(camera, *data.features, data.pattern, num_threads);
}

ExperimentResult ComputeUserBudget(const ExperimentOptions& options) {
  const BudgetInput input = MakeUserInput(options.data, options.num_threads);
  const ResidualBudget budget = ComputeResidualBudget(input);
  if (!budget.unobservable_reason.empty())
    throw Error(
        ExitCode::kInsufficientData,
        "residual-budget: not observable: " + budget.unobservable_reason);
  ExperimentResult table;
  table.conditions = {
      {"residuals",
       fmt::format("{} features in {} views, {} x {} px", budget.num_features,
                   budget.num_views, input.image_size.width,
                   input.image_size.height)},
      {"rms", fmt::format("{:.3g} px per axis", budget.rms_px)},
      {"noise", fmt::format("{:.2g} px in x, {:.2g} px in y",
                            budget.noise_px.x(), budget.noise_px.y())}};
  AddVerdict(budget, "", &table);
  table.columns = {"cause", "part_percent", "alone_percent",
                   "chance_high_percent", "remark"};
  AddShare("noise", budget.noise, &table);
  AddShare("outliers", budget.large, &table);
  for (int k = 0; k < kNumErrorCauses; ++k)
    AddCauseRow(static_cast<ErrorCause>(k),
                budget.Of(static_cast<ErrorCause>(k)), &table);
  AddShare("unexplained", budget.rest, &table);
  table.chart = MakeBudgetChart(budget);
  return table;
}

// ---- Simulated faults -------------------------------------------------------

ExperimentResult ComputeFaultBudgets(const ExperimentOptions& options) {
  constexpr char kCameraModel[] = "example";
  const auto camera = MakeSimulatedCamera(kCameraModel, options.size);
  const Pattern pattern = ChessboardPattern(17, 11, 0.024);
  SimulationOptions simulation;
  simulation.num_images = options.num_images;
  simulation.features_per_image = 120;
  simulation.seed = options.seed + 1;
  ExperimentResult table;
  table.conditions = {
      {"features",
       fmt::format("simulated, {} images of {} x {} px", options.num_images,
                   options.size.width, options.size.height)},
      {"lens", kCameraModel},
      {"camera", "ground truth, with estimated poses"},
      {"noise", fmt::format("{:g} px per axis", simulation.noise_px)},
      {"seed", std::to_string(options.seed)}};
  table.columns = {"fault", "limited_by", "rms_px", "noise_px", "noise"};
  table.chart.title = "Residual budget of simulated effects";
  table.chart.note = "one effect per group; each series is an estimated cause";
  table.chart.x_label = "fault";
  table.chart.y_label = "fraction of the squared residuals, %";
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const char* name = ToString(static_cast<ErrorCause>(k));
    table.columns.push_back(name);
    table.chart.series.push_back({name, {}, false});
  }
  table.columns.push_back("outliers");
  table.columns.push_back("unexplained");
  for (int f = 0; f < kNumFaults; ++f) {
    const auto fault = static_cast<SimulatedFault>(f);
    const Dataset seen =
        SimulateFaultyObservations(*camera, pattern, simulation, fault);
    const ResidualBudget budget = ComputeResidualBudget(
        MakeBudgetInput(*camera, seen, pattern, options.num_threads));
    std::vector<Cell> row = {std::string(ToString(fault)),
                             AssessBudget(budget).limit, budget.rms_px,
                             budget.noise_px.mean(), ToPercent(budget.noise)};
    table.chart.ticks.push_back({double(f), ToString(fault)});
    for (int k = 0; k < kNumErrorCauses; ++k) {
      const double part =
          budget.Of(static_cast<ErrorCause>(k)).sequential_share;
      row.push_back(ToPercent(part));
      table.chart.series[k].points.push_back({double(f), 100 * part});
    }
    row.push_back(ToPercent(budget.large));
    row.push_back(ToPercent(budget.rest));
    table.rows.push_back(std::move(row));
    if (options.progress) options.progress((f + 1.0) / kNumFaults);
  }
  return table;
}

}  // namespace

ExperimentResult SplitResiduals(const ExperimentOptions& options) {
  const ExperimentData& data = options.data;
  if (data.result || data.features || !data.cameras.empty())
    return ComputeUserBudget(options);
  return ComputeFaultBudgets(options);
}

}  // namespace raygrid
