#include "target/board_yaml.h"

#include <fmt/format.h>

#include "appearance/board_appearance.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

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

std::string MakeBoardsYaml(const std::vector<Board>& boards) {
  std::string yaml = "raygrid_pattern: 1\nboards:\n";
  for (const Board& board : boards) yaml += KindOf(board).Format(board);
  return yaml;
}

std::string MakeBoardsYaml(const std::vector<Board>& boards,
                           const BoardPosition& place,
                           const PrintScale& scale) {
  const std::string yaml =
      MakeBoardsYaml(MeanScaled(boards, scale)) +
      fmt::format(
          "page: {{width_m: {:.9g}, height_m: {:.9g}, first_feature_m: "
          "[{:.9g}, {:.9g}]}}\n",
          place.width_mm / 1000, place.height_mm / 1000,
          place.first_feature_mm.x() / 1000, place.first_feature_mm.y() / 1000);
  return scale.x == scale.y ? yaml : WithScaledPoints(yaml, boards, scale);
}

void RequirePossibleBoards(const std::vector<Board>& boards) {
  try {
    ParsePattern("the pattern", MakeBoardsYaml(boards));
    for (const Board& board : boards) BoardAppearance{board};
  } catch (const InputError& error) {
    throw Error(ExitCode::kUsage, error.what());
  }
}

}  // namespace raygrid
