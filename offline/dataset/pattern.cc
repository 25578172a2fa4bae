#include "dataset/pattern.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "dataset/files.h"
#include "dataset/kinds/board_keys.h"
#include "dataset/kinds/target_kind.h"
#include "dataset/pose_node.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

constexpr double kMaxCoordinateM = 1e5;  // limit for points of targets

// Throws if boards share a tag: they would be indistinguishable.
void RequireDistinctTags(const std::string& name, const Pattern& pattern) {
  std::map<int, int> board_by_tag;
  for (const Board& board : pattern.boards) {
    for (const BoardTag& tag : board.tags) {
      const auto [position, is_new] = board_by_tag.emplace(tag.id, board.id);
      if (!is_new)
        throw InputError(
            fmt::format("{}: tag {} is on both board {} and board {}; tag ids "
                        "must be unique",
                        name, tag.id, position->second, board.id));
    }
  }
}

std::vector<Eigen::Vector3d> ParsePoints(const std::string& position,
                                         const YAML::Node& list) {
  std::vector<Eigen::Vector3d> points;
  for (const YAML::Node& item : list) {
    const auto xyz = item.as<std::vector<double>>();
    const auto is_far = [](double x) {
      return !(std::abs(x) <= kMaxCoordinateM);
    };
    if (xyz.size() != 3 || std::any_of(xyz.begin(), xyz.end(), is_far))
      throw InputError(fmt::format(
          "{}: each point must be three numbers in metres, at most {:g}",
          position, kMaxCoordinateM));
    points.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  return points;
}

Board ParseBoard(const std::string& position, const YAML::Node& node) {
  Board board;
  board.id = Value<int>(position, node, "id");
  board.kind = Value<std::string>(position, node, "kind");
  const TargetKind& kind = KindOf(board);
  kind.Read(position, node, &board);
  if (node[kind.points_key])
    board.points = ParsePoints(position, node[kind.points_key]);
  if (static_cast<int>(board.points.size()) != board.num_points())
    throw InputError(fmt::format("{0}: expected {2} x {3} points, found {1}",
                                 position, board.points.size(), board.columns,
                                 board.rows));
  return board;
}

// Also throws exceptions of yaml-cpp.
std::vector<RigidTarget> ParseRigidTargets(const std::string& name,
                                           const YAML::Node& list,
                                           const Pattern& pattern) {
  if (!list.IsSequence())
    throw InputError(name + ": 'board_bodies' is not a list");
  std::vector<RigidTarget> rigid_targets;
  std::set<int> used;
  for (const YAML::Node& item : list) {
    RigidTarget& body = rigid_targets.emplace_back();
    body.boards = item["boards"].as<std::vector<int>>();
    for (const int id : body.boards)
      if (!pattern.FindBoard(id) || !used.insert(id).second)
        throw InputError(fmt::format(
            "{}: board_bodies: board {} is in two bodies, or not in 'boards'",
            name, id));
    for (const YAML::Node& pose : item["first_from_board"])
      body.first_from_board.push_back(
          ParsePose(name + ": first_from_board", pose));
    if (body.boards.size() < 2 ||
        body.first_from_board.size() != body.boards.size())
      throw InputError(fmt::format(
          "{}: board_bodies: {} boards with {} poses; a rigid multi-board "
          "target requires at least two boards and one pose per board",
          name, body.boards.size(), body.first_from_board.size()));
  }
  return rigid_targets;
}

YAML::Node MakeRigidTargetsNode(const std::vector<RigidTarget>& rigid_targets) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const RigidTarget& body : rigid_targets) {
    YAML::Node node;
    node["boards"] = body.boards;
    node["boards"].SetStyle(YAML::EmitterStyle::Flow);
    for (const Pose& pose : body.first_from_board)
      node["first_from_board"].push_back(YAML::Load(FormatPose(pose, "")));
    list.push_back(node);
  }
  return list;
}

}  // namespace

void CheckPointLimit(const std::string& position, size_t count) {
  if (count > kMaxPatternPoints)
    throw InputError(
        fmt::format("{}: {} feature points exceed the limit of {} per pattern; "
                    "check columns and rows",
                    position, count, kMaxPatternPoints));
}

std::vector<Eigen::Vector3d> Board::NominalPoints() const {
  const TargetKind& target_kind = KindOf(kind);
  if (target_kind.is_point_set) return points;
  std::vector<Eigen::Vector3d> nominal;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      nominal.emplace_back(target_kind.GetPosition(*this, column),
                           target_kind.GetPosition(*this, row), 0);
  return nominal;
}

bool Board::IsPointSet() const { return KindOf(kind).is_point_set; }

bool Board::IsTagGrid() const { return KindOf(kind).is_tag_grid; }

int Board::NumRotations() const { return KindOf(kind).NumRotations(*this); }

std::pair<int, int> Board::Rotated(int column, int row, int turn) const {
  const int quarters = 4 / NumRotations() * turn % 4;
  if (quarters == 0) return {column, row};
  if (quarters == 2) return {columns - 1 - column, rows - 1 - row};
  return quarters == 1 ? std::pair(rows - 1 - row, column)
                       : std::pair(row, columns - 1 - column);
}

bool Board::HasFeature(int column, int row) const {
  return std::none_of(tags.begin(), tags.end(), [&](const BoardTag& tag) {
    return column >= tag.column && column <= tag.column + tag.squares &&
           row >= tag.row && row <= tag.row + tag.squares;
  });
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
  RequireYamlFile(name, yaml);
  YAML::Node root;
  try {
    root = YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}, line {}: invalid YAML ({})", name,
                                 error.mark.line + 1, error.msg));
  }
  ReadNamingFile(name, [&root] { RequireKind(root, "pattern"); });
  if (Value<int>(name, root, "raygrid_pattern") != 1)
    throw InputError(
        fmt::format("{}: unsupported version of pattern.yaml", name));
  if (!root["boards"].IsSequence() || root["boards"].size() == 0)
    throw InputError(
        fmt::format("{}: 'boards' must list at least one board", name));
  size_t num_points = 0;
  try {
    for (size_t i = 0; i < root["boards"].size(); ++i) {
      const std::string position = fmt::format("{}, board {}", name, i + 1);
      if (!root["boards"][i].IsMap())
        throw InputError(fmt::format("{}: not a mapping", position));
      Board board = ParseBoard(position, root["boards"][i]);
      if (pattern.FindBoard(board.id))
        throw InputError(
            fmt::format("{}: duplicate id {}", position, board.id));
      num_points += board.points.size();
      CheckPointLimit(position, num_points);
      pattern.boards.push_back(std::move(board));
    }
    RequireDistinctTags(name, pattern);
    if (root["board_bodies"])
      pattern.rigid_targets =
          ParseRigidTargets(name, root["board_bodies"], pattern);
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
    board[KindOf(pattern.boards[i]).points_key] = points;
  }
  root.remove("board_bodies");
  if (!pattern.rigid_targets.empty())
    root["board_bodies"] = MakeRigidTargetsNode(pattern.rigid_targets);
  // The mandatory key is written last: truncated files are invalid.
  root.remove("raygrid_pattern");
  root["raygrid_pattern"] = 1;
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
