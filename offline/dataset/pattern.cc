#include "dataset/pattern.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

constexpr int kMaxFeaturesAlongSide = 1000;

// A value of a board; throws with the board's number and the key.
template <typename T>
T Value(const std::string& place, const YAML::Node& node, const char* key) {
  if (!node[key])
    throw InputError(fmt::format("{}: no '{}'; add it", place, key));
  try {
    return node[key].as<T>();
  } catch (const YAML::Exception&) {
    throw InputError(
        fmt::format("{}: '{}' has a value of the wrong kind", place, key));
  }
}

std::vector<Eigen::Vector3d> ParsePoints(const std::string& place,
                                         const YAML::Node& list) {
  std::vector<Eigen::Vector3d> points;
  for (const YAML::Node& item : list) {
    const auto xyz = item.as<std::vector<double>>();
    if (xyz.size() != 3 || !std::isfinite(xyz[0] + xyz[1] + xyz[2]))
      throw InputError(
          fmt::format("{}: a point is not three finite numbers", place));
    points.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  return points;
}

Board ParseBoard(const std::string& place, const YAML::Node& node) {
  Board board;
  board.id = Value<int>(place, node, "id");
  board.kind = Value<std::string>(place, node, "kind");
  const char* points_key = "points";
  if (board.kind == "points") {
    points_key = "xyz";
    board.columns = static_cast<int>(node["xyz"].size());
    board.rows = 1;
  } else {
    board.columns = Value<int>(place, node, "columns");
    board.rows = Value<int>(place, node, "rows");
    board.square_m = Value<double>(place, node, "square_m");
    if (std::min(board.columns, board.rows) < 2 ||
        std::max(board.columns, board.rows) > kMaxFeaturesAlongSide ||
        !(board.square_m > 0) || !std::isfinite(board.square_m))
      throw InputError(
          fmt::format("{}: columns and rows must be 2 to {}, square_m positive",
                      place, kMaxFeaturesAlongSide));
    board.points = board.NominalPoints();
  }
  if (node[points_key]) board.points = ParsePoints(place, node[points_key]);
  if (static_cast<int>(board.points.size()) != board.num_points())
    throw InputError(fmt::format("{}: {} points where {} x {} were expected",
                                 place, board.points.size(), board.columns,
                                 board.rows));
  return board;
}

}  // namespace

std::vector<Eigen::Vector3d> Board::NominalPoints() const {
  if (kind == "points") return points;
  std::vector<Eigen::Vector3d> nominal;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      nominal.emplace_back(column * square_m, row * square_m, 0);
  return nominal;
}

const Board* Pattern::FindBoard(int id) const {
  const auto found =
      std::find_if(boards.begin(), boards.end(),
                   [id](const Board& board) { return board.id == id; });
  return found == boards.end() ? nullptr : &*found;
}

Pattern ParsePattern(const std::string& name, const std::string& yaml) {
  Pattern pattern;
  pattern.yaml = yaml;
  YAML::Node root;
  try {
    root = YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}, line {}: not YAML ({})", name,
                                 error.mark.line + 1, error.msg));
  }
  if (!root.IsMap() || !root["raygrid_pattern"])
    throw InputError(
        fmt::format("{}: not a pattern (no 'raygrid_pattern: 1')", name));
  if (Value<int>(name, root, "raygrid_pattern") != 1)
    throw InputError(fmt::format("{}: unknown version of pattern.yaml", name));
  if (!root["boards"].IsSequence() || root["boards"].size() == 0)
    throw InputError(fmt::format("{}: 'boards' is no list with a board", name));
  try {
    for (size_t i = 0; i < root["boards"].size(); ++i) {
      const std::string place = fmt::format("{}, board {}", name, i + 1);
      if (!root["boards"][i].IsMap())
        throw InputError(fmt::format("{}: not a mapping", place));
      Board board = ParseBoard(place, root["boards"][i]);
      if (pattern.FindBoard(board.id))
        throw InputError(
            fmt::format("{}: id {} stands twice", place, board.id));
      pattern.boards.push_back(std::move(board));
    }
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}: {}", name, error.what()));
  }
  return pattern;
}

Pattern ReadPattern(const std::string& path) {
  return ParsePattern(path, ReadFile(path));
}

std::string FormatPattern(const Pattern& pattern) {
  YAML::Node root = YAML::Load(pattern.yaml);
  for (size_t i = 0; i < pattern.boards.size(); ++i) {
    YAML::Node points(YAML::NodeType::Sequence);
    for (const Eigen::Vector3d& point : pattern.boards[i].points) {
      YAML::Node xyz(YAML::NodeType::Sequence);
      xyz.SetStyle(YAML::EmitterStyle::Flow);
      for (int k = 0; k < 3; ++k)
        xyz.push_back(fmt::format("{:.9f}", point[k]));
      points.push_back(xyz);
    }
    YAML::Node board = root["boards"][i];
    board.SetStyle(YAML::EmitterStyle::Block);
    board[pattern.boards[i].kind == "points" ? "xyz" : "points"] = points;
  }
  YAML::Emitter emitter;
  emitter << root;
  return std::string(emitter.c_str()) + "\n";
}

Pattern ChessboardPattern(int columns, int rows, double square_m) {
  return ParsePattern(
      "chessboard",
      fmt::format("raygrid_pattern: 1\nboards:\n  - {{id: 0, kind: chessboard, "
                  "columns: {}, rows: {}, square_m: {}}}\n",
                  columns, rows, square_m));
}

}  // namespace raygrid
