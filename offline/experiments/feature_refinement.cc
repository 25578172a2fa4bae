#include "experiments/experiment.h"
#include "experiments/localization_error.h"

namespace raygrid {
namespace {

struct NamedRefinement {
  const char* name;
  Refinement refinement;
};

constexpr NamedRefinement kRefinements[] = {
    {"intensities", Refinement::kIntensities},
    {"gradients-xy", Refinement::kGradientsXY},
    {"gradient-magnitude", Refinement::kGradientMagnitude},
    {"corner-subpix", Refinement::kCornerSubpix},
    {"none", Refinement::kNone}};

constexpr int kSegments = 16;

std::vector<DetectionOptions> AllWays() {
  std::vector<DetectionOptions> ways;
  for (const NamedRefinement& refinement : kRefinements) {
    ways.emplace_back();
    ways.back().refinement = refinement.refinement;
  }
  return ways;
}

}  // namespace

ExperimentResult CompareFeatureRefinements(const ExperimentOptions& options) {
  const std::vector<DetectedBoard> boards = {
      {ExperimentStarBoard(kSegments), AllWays()},
      {ExperimentChessboard(), AllWays()}};
  const std::vector<LocalizationError> errors =
      MeasureLocalization(boards, options);

  ExperimentResult result;
  result.conditions = LocalizationConditions(options);
  result.conditions.push_back(
      {"stars", std::to_string(kSegments) + " segments"});
  result.columns = LocalizationColumns();
  result.columns.insert(result.columns.begin(), {"pattern", "refinement"});
  Chart& chart = result.chart;
  chart = {"Error of localisation by refinement",
           LocalizationNote(options),
           "refinement",
           "error in an axis, mean of both, px",
           {},
           true,
           {}};
  for (const NamedRefinement& refinement : kRefinements)
    chart.ticks.push_back(
        {static_cast<double>(chart.ticks.size()), refinement.name});
  size_t i = 0;
  for (const DetectedBoard& detected : boards) {
    const std::string& kind = detected.board.kind;
    ChartSeries rms = {"RMS, " + kind, {}, false};
    ChartSeries median = {"median, " + kind, {}, false};
    double place = 0;
    for (const NamedRefinement& refinement : kRefinements) {
      std::vector<Cell> row = LocalizationCells(errors[i]);
      row.insert(row.begin(), {Cell(kind), Cell(refinement.name)});
      result.rows.push_back(std::move(row));
      rms.points.push_back({place, errors[i].rms_px.mean()});
      median.points.push_back({place, errors[i].median_px.mean()});
      ++place;
      ++i;
    }
    chart.series.push_back(std::move(rms));
    chart.series.push_back(std::move(median));
  }
  return result;
}

}  // namespace raygrid
