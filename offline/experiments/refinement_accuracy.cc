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

std::vector<DetectedBoard> SelectBoardsToRefine() {
  std::vector<DetectionOptions> ways;
  for (const NamedRefinement& refinement : kRefinements) {
    ways.emplace_back();
    ways.back().refinement = refinement.refinement;
  }
  return {{ExperimentStarBoard(kSegments), ways},
          {ExperimentChessboard(), ways}};
}

Chart MakeEmptyChart(const ExperimentOptions& options) {
  Chart chart;
  chart.title = "Feature localization error by refinement";
  chart.note = LocalizationNote(options);
  chart.x_label = "refinement";
  chart.y_label = "error per axis, px";
  chart.is_logarithmic = true;
  for (const NamedRefinement& refinement : kRefinements)
    chart.ticks.push_back({double(chart.ticks.size()), refinement.name});
  return chart;
}

// errors: an array with one element per refinement method.
void AddBoard(const std::string& kind, const LocalizationError* errors,
              ExperimentResult* result) {
  ChartSeries rms = {"RMS, " + kind, {}, false};
  ChartSeries median = {"median, " + kind, {}, false};
  double place = 0;
  for (const NamedRefinement& refinement : kRefinements) {
    result->rows.push_back(
        LocalizationCells({kind, std::string(refinement.name)}, *errors));
    rms.points.push_back({place, errors->rms_px.mean()});
    median.points.push_back({place, errors->median_px.mean()});
    ++place;
    ++errors;
  }
  result->chart.series.push_back(std::move(rms));
  result->chart.series.push_back(std::move(median));
}

}  // namespace

ExperimentResult CompareFeatureRefinements(const ExperimentOptions& options) {
  const std::vector<DetectedBoard> boards = SelectBoardsToRefine();
  const std::vector<LocalizationError> errors =
      MeasureLocalization(boards, options);
  ExperimentResult result;
  result.conditions = ListLocalizationConditions(options);
  result.conditions.push_back(
      {"stars", std::to_string(kSegments) + " segments"});
  result.columns = LocalizationColumns({"pattern", "refinement"});
  result.chart = MakeEmptyChart(options);
  const LocalizationError* board_errors = errors.data();
  for (const DetectedBoard& board : boards) {
    AddBoard(board.board.kind, board_errors, &result);
    board_errors += board.ways.size();
  }
  return result;
}

}  // namespace raygrid
