#include "experiments/experiment.h"
#include "experiments/localization_error.h"

namespace raygrid {
namespace {

// The paper's numbers. Its deltilles, on a triangular lattice, are no kind of
// board here; stars of 6 segments stand for them.
constexpr int kSegments[] = {4, 6, 8, 12, 16, 20, 24, 28, 32};
constexpr int kChessboardSegments = 4;  // that meet in a corner

}  // namespace

ExperimentResult ComparePatternSegments(const ExperimentOptions& options) {
  std::vector<DetectedBoard> boards;
  for (const int segments : kSegments)
    boards.push_back({ExperimentStarBoard(segments), {{}}});
  boards.push_back({ExperimentChessboard(), {{}}});
  const std::vector<LocalizationError> errors =
      MeasureLocalization(boards, options);

  ExperimentResult result;
  result.conditions = LocalizationConditions(options);
  result.conditions.push_back(
      {"chessboard", "squares as wide as a star's: twice those of 4 segments"});
  result.conditions.push_back({"left out", "deltilles, on another lattice"});
  result.columns = LocalizationColumns();
  result.columns.insert(result.columns.begin(), {"pattern", "segments"});
  Chart& chart = result.chart;
  chart = {"Error of localisation by the number of star segments",
           LocalizationNote(options),
           "star segments, black and white",
           "error in an axis, mean of both, px",
           {},
           false,
           {{"RMS, stars", {}, true},
            {"median, stars", {}, true},
            {"RMS, chessboard", {}, false},
            {"median, chessboard", {}, false}}};
  for (size_t i = 0; i < boards.size(); ++i) {
    const bool is_star = boards[i].board.kind == "star";
    const int segments =
        is_star ? boards[i].board.segments : kChessboardSegments;
    std::vector<Cell> row = LocalizationCells(errors[i]);
    row.insert(row.begin(), {Cell(boards[i].board.kind), Cell(segments)});
    result.rows.push_back(std::move(row));
    if (is_star)
      chart.ticks.push_back({double(segments), std::to_string(segments)});
    const size_t series = is_star ? 0 : 2;
    chart.series[series].points.push_back(
        {double(segments), errors[i].rms_px.mean()});
    chart.series[series + 1].points.push_back(
        {double(segments), errors[i].median_px.mean()});
  }
  return result;
}

}  // namespace raygrid
