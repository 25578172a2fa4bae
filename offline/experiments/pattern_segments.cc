#include "experiments/experiment.h"
#include "experiments/localization_error.h"

namespace raygrid {
namespace {

// The segment counts of the paper. Its deltilles, on a triangular grid, are not
// supported; stars with 6 segments are used instead.
constexpr int kSegmentCounts[] = {4, 6, 8, 12, 16, 20, 24, 28, 32};
constexpr int kChessboardSegments = 4;  // meet at each corner

std::vector<DetectedBoard> MakeSegmentBoards() {
  std::vector<DetectedBoard> boards;
  for (const int segments : kSegmentCounts)
    boards.push_back({ExperimentStarBoard(segments), {{}}});
  boards.push_back({ExperimentChessboard(), {{}}});
  return boards;
}

int Segments(const Board& board) {
  return board.segments > 0 ? board.segments : kChessboardSegments;
}

// Six triangles meet at each corner of a deltille, as in stars with six
// segments.
constexpr char kDeltille[] = "deltille-like";
constexpr int kDeltilleSegments = 6;

std::string Name(const Board& board) {
  return board.segments == kDeltilleSegments ? kDeltille : board.kind;
}

Chart MakeEmptySegmentChart(const ExperimentOptions& options) {
  Chart chart;
  chart.title = "Feature localization error by number of star segments";
  chart.note = LocalizationNote(options);
  chart.x_label = "star segments, black and white";
  chart.y_label = "error per axis, px";
  for (const int segments : kSegmentCounts)
    chart.ticks.push_back({double(segments), std::to_string(segments)});
  chart.series = {{"RMS, stars", {}, true},
                  {"median, stars", {}, true},
                  {"RMS, chessboard", {}, false},
                  {"median, chessboard", {}, false},
                  {std::string("RMS, ") + kDeltille, {}, false},
                  {std::string("median, ") + kDeltille, {}, false}};
  return chart;
}

void AddToChart(const Board& board, const LocalizationError& error,
                Chart* chart) {
  const double x = Segments(board);
  const auto add = [&](size_t series) {
    chart->series[series].points.push_back({x, error.rms_px.mean()});
    chart->series[series + 1].points.push_back({x, error.median_px.mean()});
  };
  add(board.segments > 0 ? 0 : 2);
  if (Name(board) == kDeltille) add(4);
}

}  // namespace

ExperimentResult ComparePatternSegments(const ExperimentOptions& options) {
  const std::vector<DetectedBoard> boards = MakeSegmentBoards();
  const std::vector<LocalizationError> errors =
      MeasureLocalization(boards, options);
  ExperimentResult result;
  result.conditions = ListLocalizationConditions(options);
  result.conditions.push_back(
      {"chessboard", "squares as wide as the spacing of stars"});
  result.conditions.push_back(
      {kDeltille, "the corners of a triangular lattice, at other positions"});
  result.columns = LocalizationColumns({"pattern", "segments"});
  result.chart = MakeEmptySegmentChart(options);
  for (size_t i = 0; i < boards.size(); ++i) {
    const Board& board = boards[i].board;
    result.rows.push_back(
        LocalizationCells({Name(board), Segments(board)}, errors[i]));
    AddToChart(board, errors[i], &result.chart);
  }
  return result;
}

}  // namespace raygrid
