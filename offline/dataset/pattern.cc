#include "dataset/pattern.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/pose_node.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

constexpr int kMaxFeaturesAlongSide = 1000;
// Points of all boards together. Every point is adjusted and written, seen or
// not.
// No board is beyond these; arithmetic far beyond ends in nonsense.
constexpr double kMinSquareM = 1e-6, kMaxSquareM = 100;
constexpr double kMaxCoordinateM = kMaxFeaturesAlongSide * kMaxSquareM;

// A value of a board; throws with the board's number and the key.
template <typename T>
T Value(const std::string& place, const YAML::Node& node, const char* key) {
  if (!node[key])
    throw InputError(fmt::format("{}: missing key '{}'", place, key));
  try {
    return node[key].as<T>();
  } catch (const YAML::Exception&) {
    throw InputError(
        fmt::format("{}: '{}' has a value of the wrong type", place, key));
  }
}

template <typename T>
T OptionalValue(const std::string& place, const YAML::Node& node,
                const char* key, T otherwise) {
  return node[key] ? Value<T>(place, node, key) : otherwise;
}

BoardTag ParseTag(const std::string& place, const YAML::Node& node) {
  BoardTag tag;
  tag.family = OptionalValue<std::string>(place, node, "family", tag.family);
  tag.id = Value<int>(place, node, "id");
  tag.column = Value<int>(place, node, "column");
  tag.row = Value<int>(place, node, "row");
  tag.squares = Value<int>(place, node, "squares");
  if (tag.family != "tag36h11")
    throw InputError(fmt::format(
        "{}: unsupported tag family '{}'; use tag36h11", place, tag.family));
  return tag;
}

void ParseStar(const std::string& place, const YAML::Node& node, Board* board) {
  board->segments = OptionalValue<int>(place, node, "segments", 16);
  if (board->segments < 4 || board->segments > 64 || board->segments % 2 != 0)
    throw InputError(fmt::format(
        "{}: 'segments' must be an even number from 4 to 64", place));
  if (!node["tags"].IsSequence() || node["tags"].size() == 0)
    throw InputError(fmt::format(
        "{}: 'tags' must list at least one tag for a star board", place));
  for (const YAML::Node& item : node["tags"]) {
    const BoardTag tag = ParseTag(place, item);
    if (tag.squares < 1 || tag.column < -1 || tag.row < -1 ||
        tag.column + tag.squares > board->columns ||
        tag.row + tag.squares > board->rows)
      throw InputError(
          fmt::format("{}: tag {} is outside the board", place, tag.id));
    board->tags.push_back(tag);
  }
}

void ParseCharuco(const std::string& place, const YAML::Node& node,
                  Board* board) {
  board->marker_m = Value<double>(place, node, "marker_m");
  board->dictionary = Value<std::string>(place, node, "dictionary");
  board->is_legacy = OptionalValue<bool>(place, node, "legacy", false);
  board->first_marker = OptionalValue<int>(place, node, "first_marker", 0);
  if (!(board->marker_m > 0 && board->marker_m < board->square_m))
    throw InputError(
        fmt::format("{}: 'marker_m' must be between 0 and square_m", place));
}

void RequireTagFamily(const std::string& place, const Board& board) {
  const std::string& family = board.tag_family;
  if (family == "tag36h11" || family == "tag25h9" || family == "tag16h5")
    return;
  if (family.compare(0, 5, "DICT_") != 0)
    throw InputError(
        fmt::format("{}: unsupported tag family '{}'; use tag36h11, tag25h9, "
                    "tag16h5 or a dictionary such as DICT_4X4_50",
                    place, family));
  if (board.has_corner_squares)
    throw InputError(fmt::format(
        "{}: tag family '{}': dictionary markers are supported without corner "
        "squares only; set 'corner_squares: false' if there are none",
        place, family));
}

void ParseAprilGrid(const std::string& place, const YAML::Node& node,
                    Board* board) {
  board->tag_family =
      OptionalValue<std::string>(place, node, "tag_family", "tag36h11");
  board->spacing_ratio = Value<double>(place, node, "spacing_ratio");
  board->first_marker = OptionalValue<int>(place, node, "first_marker", 0);
  SetCornerSquares(OptionalValue<bool>(place, node, "corner_squares", true),
                   board);
  board->border_cells =
      OptionalValue<int>(place, node, "border_cells", board->border_cells);
  const auto numbered_from = OptionalValue<std::string>(
      place, node, "numbered_from",
      board->is_numbered_from_top ? "top" : "bottom");
  board->is_numbered_from_top = numbered_from == "top";
  RequireTagFamily(place, *board);
  if (numbered_from != "top" && numbered_from != "bottom")
    throw InputError(
        fmt::format("{}: numbered_from must be top or bottom, not '{}'", place,
                    numbered_from));
  if (board->border_cells != 1 && board->border_cells != 2)
    throw InputError(fmt::format("{}: 'border_cells' must be 1 or 2", place));
  if (!(board->spacing_ratio > 0 && board->spacing_ratio < 10))
    throw InputError(
        fmt::format("{}: 'spacing_ratio' must be positive", place));
  if (board->columns % 2 != 0 || board->rows % 2 != 0)
    throw InputError(
        fmt::format("{}: columns and rows of an AprilGrid must be even, with 2 "
                    "x 2 features per tag",
                    place));
}

// Two boards with one tag could not be told apart.
void RequireDistinctTags(const std::string& name, const Pattern& pattern) {
  std::map<int, int> board_of_tag;
  for (const Board& board : pattern.boards) {
    for (const BoardTag& tag : board.tags) {
      const auto [place, is_new] = board_of_tag.emplace(tag.id, board.id);
      if (!is_new)
        throw InputError(
            fmt::format("{}: tag {} is on both board {} and board {}; tag ids "
                        "must be unique",
                        name, tag.id, place->second, board.id));
    }
  }
}

std::vector<Eigen::Vector3d> ParsePoints(const std::string& place,
                                         const YAML::Node& list) {
  std::vector<Eigen::Vector3d> points;
  for (const YAML::Node& item : list) {
    const auto xyz = item.as<std::vector<double>>();
    const auto is_far = [](double x) {
      return !(std::abs(x) <= kMaxCoordinateM);
    };
    if (xyz.size() != 3 || std::any_of(xyz.begin(), xyz.end(), is_far))
      throw InputError(fmt::format(
          "{}: each point must be three numbers in metres, at most {:g}", place,
          kMaxCoordinateM));
    points.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  return points;
}

void RequireFewPoints(const std::string& place, size_t count) {
  if (count > kMaxPatternPoints)
    throw InputError(
        fmt::format("{}: {} feature points exceed the limit of {} per pattern; "
                    "check columns and rows",
                    place, count, kMaxPatternPoints));
}

Board ParseBoard(const std::string& place, const YAML::Node& node) {
  Board board;
  board.id = Value<int>(place, node, "id");
  board.kind = Value<std::string>(place, node, "kind");
  const char* points_key = "points";
  if (board.kind == "points") {
    points_key = "xyz";
    const int count = static_cast<int>(node["xyz"].size());
    board.columns =
        node["columns"] ? Value<int>(place, node, "columns") : count;
    board.rows = node["rows"] ? Value<int>(place, node, "rows") : 1;
    if (std::min(board.columns, board.rows) < 0 ||
        static_cast<int64_t>(board.columns) * board.rows != count)
      throw InputError(fmt::format("{0}: expected {2} x {3} points, found {1}",
                                   place, count, board.columns, board.rows));
  } else {
    board.columns = Value<int>(place, node, "columns");
    board.rows = Value<int>(place, node, "rows");
    board.square_m = Value<double>(place, node, "square_m");
    if (std::min(board.columns, board.rows) < 2 ||
        std::max(board.columns, board.rows) > kMaxFeaturesAlongSide)
      throw InputError(fmt::format("{}: columns and rows must be 2 to {}",
                                   place, kMaxFeaturesAlongSide));
    RequireFewPoints(place, board.num_points());
    if (!(board.square_m >= kMinSquareM && board.square_m <= kMaxSquareM))
      throw InputError(fmt::format(
          "{}: square_m is {:g}, but must be 1e-6 (1 µm) to {:g} metres", place,
          board.square_m, kMaxSquareM));
    if (board.kind == "star") ParseStar(place, node, &board);
    if (board.kind == "charuco") ParseCharuco(place, node, &board);
    if (board.kind == "aprilgrid") ParseAprilGrid(place, node, &board);
    board.points = board.NominalPoints();
  }
  if (node[points_key]) board.points = ParsePoints(place, node[points_key]);
  if (static_cast<int>(board.points.size()) != board.num_points())
    throw InputError(fmt::format("{0}: expected {2} x {3} points, found {1}",
                                 place, board.points.size(), board.columns,
                                 board.rows));
  return board;
}

// Throws what yaml-cpp throws, too.
std::vector<BoardBody> ParseBodies(const std::string& name,
                                   const YAML::Node& list,
                                   const Pattern& pattern) {
  if (!list.IsSequence())
    throw InputError(name + ": 'board_bodies' is not a list");
  std::vector<BoardBody> bodies;
  std::set<int> used;
  for (const YAML::Node& item : list) {
    BoardBody& body = bodies.emplace_back();
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
  return bodies;
}

YAML::Node BodiesNode(const std::vector<BoardBody>& bodies) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const BoardBody& body : bodies) {
    YAML::Node node;
    node["boards"] = body.boards;
    node["boards"].SetStyle(YAML::EmitterStyle::Flow);
    for (const Pose& pose : body.first_from_board)
      node["first_from_board"].push_back(YAML::Load(FormatPose(pose, "")));
    list.push_back(node);
  }
  return list;
}

// The place of a column or a row of features.
double Place(const Board& board, int index) {
  if (board.kind != "aprilgrid") return index * board.square_m;
  return board.square_m * (index / 2 * (1 + board.spacing_ratio) + index % 2);
}

}  // namespace

std::vector<Eigen::Vector3d> Board::NominalPoints() const {
  if (kind == "points") return points;
  std::vector<Eigen::Vector3d> nominal;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      nominal.emplace_back(Place(*this, column), Place(*this, row), 0);
  return nominal;
}

int Board::NumTurns() const {
  if (kind != "chessboard" || columns % 2 != rows % 2) return 1;
  return columns == rows && columns % 2 == 0 ? 4 : 2;
}

std::pair<int, int> Board::Turned(int column, int row, int turn) const {
  const int quarters = 4 / NumTurns() * turn % 4;
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
      const std::string place = fmt::format("{}, board {}", name, i + 1);
      if (!root["boards"][i].IsMap())
        throw InputError(fmt::format("{}: not a mapping", place));
      Board board = ParseBoard(place, root["boards"][i]);
      if (pattern.FindBoard(board.id))
        throw InputError(fmt::format("{}: duplicate id {}", place, board.id));
      num_points += board.points.size();
      RequireFewPoints(place, num_points);
      pattern.boards.push_back(std::move(board));
    }
    RequireDistinctTags(name, pattern);
    if (root["board_bodies"])
      pattern.bodies = ParseBodies(name, root["board_bodies"], pattern);
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
  root.remove("board_bodies");
  if (!pattern.bodies.empty())
    root["board_bodies"] = BodiesNode(pattern.bodies);
  // The key that no pattern lacks comes last: a file that was cut is no
  // pattern.
  root.remove("raygrid_pattern");
  root["raygrid_pattern"] = 1;
  YAML::Emitter emitter;
  emitter << root;
  return std::string(emitter.c_str()) + "\n";
}

void SetCornerSquares(bool has_corner_squares, Board* board) {
  board->has_corner_squares = has_corner_squares;
  board->border_cells = has_corner_squares ? 2 : 1;
  board->is_numbered_from_top = !has_corner_squares;
}

Pattern ChessboardPattern(int columns, int rows, double square_m) {
  return ParsePattern(
      "chessboard",
      fmt::format("raygrid_pattern: 1\nboards:\n  - {{id: 0, kind: chessboard, "
                  "columns: {}, rows: {}, square_m: {}}}\n",
                  columns, rows, square_m));
}

}  // namespace raygrid
