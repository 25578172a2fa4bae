#include "dataset/kinds/target_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/kinds/board_keys.h"

namespace raygrid {
namespace {

constexpr int kMaxFeaturesAlongSide = 1000;
// Plausible sizes of squares; far outside, results would be meaningless.
constexpr double kMinSquareM = 1e-6, kMaxSquareM = 100;

// Whether a square is black. Square (0, 0) is left of and above feature (0, 0).
bool IsBlackSquare(const Board& board, int column, int row) {
  if (board.is_legacy) row = board.rows - row;
  return (row % 2 != 0) == (column % 2 != 0);
}

std::string Corners(const Board& board) {
  return fmt::format("{} x {} inner corners", board.columns, board.rows);
}

}  // namespace

void TargetKind::Read(const std::string& position, const YAML::Node& node,
                      Board* board) const {
  board->columns = Value<int>(position, node, "columns");
  board->rows = Value<int>(position, node, "rows");
  board->square_m = Value<double>(position, node, "square_m");
  if (std::min(board->columns, board->rows) < 2 ||
      std::max(board->columns, board->rows) > kMaxFeaturesAlongSide)
    throw InputError(fmt::format("{}: columns and rows must be 2 to {}",
                                 position, kMaxFeaturesAlongSide));
  CheckPointLimit(position, board->num_points());
  if (!(board->square_m >= kMinSquareM && board->square_m <= kMaxSquareM))
    throw InputError(fmt::format(
        "{}: square_m is {:g}, but must be 1e-6 (1 µm) to {:g} metres",
        position, board->square_m, kMaxSquareM));
  ReadKeys(position, node, board);
  board->points = board->NominalPoints();
}

std::string TargetKind::Format(const Board& board) const {
  return fmt::format(
      "  - {{id: {}, kind: {}, columns: {}, rows: {}, square_m: {:.9g}{}}}\n",
      board.id, board.kind, board.columns, board.rows, board.square_m,
      FormatKeys(board));
}

double TargetKind::GetPosition(const Board& board, int index) const {
  return index * board.square_m;
}

Area TargetKind::Extent(const Board& board) const {
  const double s = board.square_m;
  return {-s, -s, board.columns * s, board.rows * s};
}

bool TargetKind::IsBlack(const Board& board, double x, double y) const {
  return IsBlackSquare(board, static_cast<int>(std::floor(x)) + 1,
                       static_cast<int>(std::floor(y)) + 1);
}

std::vector<Polygon> TargetKind::Ink(const Board& board) const {
  const double s = board.square_m;
  std::vector<Polygon> squares;
  for (int row = 0; row <= board.rows; ++row)
    for (int column = 0; column <= board.columns; ++column)
      if (IsBlackSquare(board, column, row))
        squares.push_back(RectanglePolygon((column - 1) * s, (row - 1) * s,
                                           column * s, row * s));
  return squares;
}

std::string TargetKind::Describe(const Board& board) const {
  return fmt::format("chessboard, {}, squares {:g} mm", Corners(board),
                     board.square_m * 1000);
}

std::string TargetKind::DescribeLayout(const Board& board) const {
  return Corners(board);
}

std::string TargetKind::DescribeSought(const Board& board) const {
  return "a chessboard of " + DescribeLayout(board);
}

Board TargetKind::MakeBoard(const BoardRequest& request) const {
  Board board = request.board;
  board.kind = name;
  board.square_m = request.length_mm / 1000;
  board.marker_m = request.marker_mm / 1000;
  return board;
}

const std::vector<std::unique_ptr<const TargetKind>>& TargetKinds() {
  static const auto kinds = [] {
    std::vector<std::unique_ptr<const TargetKind>> list;
#define RAYGRID_TARGET_KIND(Name) list.push_back(Make##Name##Kind());
#include "dataset/kinds/kind_list.inc"
#undef RAYGRID_TARGET_KIND
    return list;
  }();
  return kinds;
}

const TargetKind& KindOf(const std::string& name) {
  for (const auto& kind : TargetKinds())
    if (kind->name == name) return *kind;
  static const auto other = [] {
    TargetKind kind;
    kind.is_drawable = false;
    return kind;
  }();
  return other;
}

std::string DrawableKinds() {
  std::vector<std::string> names;
  for (const auto& kind : TargetKinds())
    if (kind->is_drawable) names.push_back(kind->name);
  const std::string last = names.back();
  names.pop_back();
  return fmt::format("{} or {}", fmt::join(names, ", "), last);
}

std::string FirstMarkerKey(const Board& board) {
  return board.first_marker == 0
             ? ""
             : fmt::format(", first_marker: {}", board.first_marker);
}

std::string FromMarker(const Board& board) {
  return board.first_marker == 0 ? ""
                                 : fmt::format(" from {}", board.first_marker);
}

Polygon RectanglePolygon(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

}  // namespace raygrid
