#include "target/star_boards.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kTagSideMm = 40;
constexpr int kMaxSegments = 32;  // more blur together in most photographs
constexpr int kMaxTagsOnABoard = 100;

// Tags stand in rows; row k of num_rows has this many.
int TagsInRow(int num_tags, int num_rows, int k) {
  return num_tags * (k + 1) / num_rows - num_tags * k / num_rows;
}

// The number of rows that leaves the tags farthest apart. The ink is one
// square wider and higher than there are features.
int NumTagRows(const StarBoardOptions& options) {
  int best_rows = 1;
  double best_pitch = 0;
  for (int rows = 1; rows <= options.num_tags; ++rows) {
    const int columns = (options.num_tags + rows - 1) / rows;
    const double pitch = std::min((options.columns + 1.0) / columns,
                                  (options.rows + 1.0) / rows);
    if (pitch > best_pitch) {
      best_pitch = pitch;
      best_rows = rows;
    }
  }
  return best_rows;
}

// The first lattice position of tag k of count along a side with num_features.
int TagStart(int num_features, int squares, int k, int count) {
  const double middle = -1 + (num_features + 1) * (k + 0.5) / count;
  return static_cast<int>(std::ceil(middle - squares / 2.0 - 0.5));
}

std::vector<BoardTag> PlaceTags(const StarBoardOptions& options, int squares) {
  std::vector<BoardTag> tags;
  const int num_rows = NumTagRows(options);
  for (int row = 0; row < num_rows; ++row) {
    const int count = TagsInRow(options.num_tags, num_rows, row);
    for (int k = 0; k < count; ++k) {
      BoardTag tag;
      tag.squares = squares;
      tag.column = TagStart(options.columns, squares, k, count);
      tag.row = TagStart(options.rows, squares, row, num_rows);
      tags.push_back(tag);
    }
  }
  return tags;
}

// Features surround a tag, and the next one stands apart.
bool AreApart(const StarBoardOptions& options,
              const std::vector<BoardTag>& tags) {
  for (size_t i = 0; i < tags.size(); ++i) {
    const BoardTag& a = tags[i];
    if (a.column < 1 || a.row < 1 ||
        a.column + a.squares > options.columns - 2 ||
        a.row + a.squares > options.rows - 2)
      return false;
    for (size_t j = 0; j < i; ++j)
      if (std::max(std::abs(a.column - tags[j].column),
                   std::abs(a.row - tags[j].row)) <= a.squares)
        return false;
  }
  return true;
}

void RequirePossible(const StarBoardOptions& options) {
  const auto require = [](bool is_met, const char* message) {
    if (!is_met) throw Error(ExitCode::kUsage, message);
  };
  require(options.segments >= 4 && options.segments <= kMaxSegments &&
              options.segments % 2 == 0,
          "--segments must be an even number from 4 to 32");
  require(std::min(options.columns, options.rows) >= 2 &&
              std::max(options.columns, options.rows) <= 1000 &&
              options.square_mm > 0 && std::isfinite(options.square_mm),
          "columns and rows must be 2 to 1000, and squares larger than 0 mm");
  require(options.num_boards >= 1 && options.num_boards <= 100,
          "--boards must be 1 to 100");
  require(options.num_tags >= 1 && options.num_tags <= kMaxTagsOnABoard,
          "--tags must be 1 to 100");
  require(options.tag_squares >= 0 && options.tag_squares <= 1000,
          "--tag-squares must be 0 to 1000");
  require(options.tag_id >= 0, "--tag-id must not be negative");
}

}  // namespace

int DefaultTagSquares(int columns, int rows, double square_mm) {
  const int half_board = std::max(2, (std::min(columns, rows) - 1) / 2);
  const double wanted = std::ceil(kTagSideMm / square_mm);
  return wanted > half_board ? half_board
                             : std::max(2, static_cast<int>(wanted));
}

std::vector<Board> StarBoards(const StarBoardOptions& options) {
  RequirePossible(options);
  Board board;
  board.kind = "star";
  board.columns = options.columns;
  board.rows = options.rows;
  board.square_m = options.square_mm / 1000;
  board.segments = options.segments;
  const int squares =
      options.tag_squares > 0
          ? options.tag_squares
          : DefaultTagSquares(options.columns, options.rows, options.square_mm);
  board.tags = PlaceTags(options, squares);
  if (!AreApart(options, board.tags))
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "{} tag(s) {} squares wide do not fit among {} x {} features; use "
            "fewer --tags, smaller --tag-squares or more --columns and --rows",
            options.num_tags, squares, options.columns, options.rows));
  std::vector<Board> boards;
  int tag_id = options.tag_id;
  for (board.id = 0; board.id < options.num_boards; ++board.id) {
    for (BoardTag& tag : board.tags) tag.id = tag_id++;
    boards.push_back(board);
  }
  return boards;
}

}  // namespace raygrid
