#include "target/board_yaml.h"

#include <fmt/format.h>

#include "appearance/board_appearance.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

std::string StarKeys(const Board& board) {
  std::string tags;
  for (const BoardTag& tag : board.tags)
    tags += fmt::format(
        "{}{{family: {}, id: {}, column: {}, row: {}, squares: {}}}",
        tags.empty() ? "" : ", ", tag.family, tag.id, tag.column, tag.row,
        tag.squares);
  return fmt::format(", segments: {}, tags: [{}]", board.segments, tags);
}

std::string KeysOfKind(const Board& board) {
  if (board.kind == "star") return StarKeys(board);
  std::string keys;
  if (board.kind == "charuco")
    keys = fmt::format(", marker_m: {:.9g}, dictionary: {}", board.marker_m,
                       board.dictionary);
  if (board.is_legacy) keys += ", legacy: true";
  if (board.kind == "aprilgrid")
    keys = fmt::format(", tag_family: {}, spacing_ratio: {:.9g}",
                       board.tag_family, board.spacing_ratio);
  if (!board.has_corner_squares) keys += ", corner_squares: false";
  if (board.border_cells != (board.has_corner_squares ? 2 : 1))
    keys += fmt::format(", border_cells: {}", board.border_cells);
  if (board.is_numbered_from_top == board.has_corner_squares)
    keys += fmt::format(", numbered_from: {}",
                        board.is_numbered_from_top ? "top" : "bottom");
  if (board.first_marker != 0)
    keys += fmt::format(", first_marker: {}", board.first_marker);
  return keys;
}

// A board that is points alone.
std::string PointsYaml(const Board& board) {
  std::string yaml = fmt::format(
      "  - id: {}\n    kind: points\n    columns: {}\n    rows: {}\n    "
      "xyz:\n",
      board.id, board.columns, board.rows);
  for (const Eigen::Vector3d& point : board.points)
    yaml += fmt::format("      - [{:.9f}, {:.9f}, {:.9f}]\n", point.x(),
                        point.y(), point.z());
  return yaml;
}

std::string BoardYaml(const Board& board) {
  if (board.kind == "points") return PointsYaml(board);
  return fmt::format(
      "  - {{id: {}, kind: {}, columns: {}, rows: {}, square_m: {:.9g}{}}}\n",
      board.id, board.kind, board.columns, board.rows, board.square_m,
      KeysOfKind(board));
}

std::vector<Board> MeanScaled(std::vector<Board> boards,
                              const PrintScale& scale) {
  for (Board& board : boards) {
    board.square_m *= (scale.x + scale.y) / 2;
    board.marker_m *= (scale.x + scale.y) / 2;
  }
  return boards;
}

std::string WithScaledPoints(const std::string& yaml,
                             const std::vector<Board>& drawn,
                             const PrintScale& scale) {
  Pattern pattern = ParsePattern("pattern.yaml", yaml);
  for (size_t i = 0; i < drawn.size(); ++i) {
    pattern.boards[i].points = drawn[i].NominalPoints();
    for (Eigen::Vector3d& point : pattern.boards[i].points)
      point = {point.x() * scale.x, point.y() * scale.y, 0};
  }
  return FormatPattern(pattern);
}

}  // namespace

std::string BoardsYaml(const std::vector<Board>& boards) {
  std::string yaml = "raygrid_pattern: 1\nboards:\n";
  for (const Board& board : boards) yaml += BoardYaml(board);
  return yaml;
}

std::string BoardsYaml(const std::vector<Board>& boards,
                       const BoardPlace& place, const PrintScale& scale) {
  const std::string yaml =
      BoardsYaml(MeanScaled(boards, scale)) +
      fmt::format(
          "page: {{width_m: {:.9g}, height_m: {:.9g}, first_feature_m: "
          "[{:.9g}, {:.9g}]}}\n",
          place.width_mm / 1000, place.height_mm / 1000,
          place.first_feature_mm.x() / 1000, place.first_feature_mm.y() / 1000);
  return scale.x == scale.y ? yaml : WithScaledPoints(yaml, boards, scale);
}

void RequirePossibleBoards(const std::vector<Board>& boards) {
  try {
    ParsePattern("the pattern", BoardsYaml(boards));
    for (const Board& board : boards) BoardAppearance{board};
  } catch (const InputError& error) {
    throw Error(ExitCode::kUsage, error.what());
  }
}

}  // namespace raygrid
