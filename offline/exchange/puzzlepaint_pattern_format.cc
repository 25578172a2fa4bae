#include "exchange/puzzlepaint_pattern_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "dataset/error.h"
#include "dataset/yaml_file.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kStarSegments[] = "num_star_segments";

int ReadCountInRange(const YAML::Node& node, const std::string& name, int least,
                     int most) {
  const double count = FiniteNumber(node, name);
  if (!(count >= least && count <= most) || count != std::floor(count))
    throw InputError(fmt::format("{}: must be {} to {}", name, least, most));
  return static_cast<int>(count);
}

// Stars are located at inner corners of squares: the first one is a square from
// the pattern's edge, where tag coordinates start.
BoardTag ReadPatternTag(const YAML::Node& node, const std::string& name) {
  constexpr int kMaxSquareCount = 1001, kMostId = 586;
  if (!node.IsMap()) throw InputError(name + ": expected a mapping");
  const auto number = [&](const char* key, int most) {
    return ReadCountInRange(node[key], fmt::format("{}: {}", name, key), 0,
                            most);
  };
  BoardTag tag;
  tag.id = number("index", kMostId);
  tag.column = number("tag_x", kMaxSquareCount) - 1;
  tag.row = number("tag_y", kMaxSquareCount) - 1;
  tag.squares = number("width", kMaxSquareCount);
  if (number("height", kMaxSquareCount) != tag.squares)
    throw InputError(name + ": width and height of a tag must be equal");
  return tag;
}

ExchangeContents ReadPuzzlepaintPattern(const ReadRequest& request) {
  constexpr int kMinSquares = 3, kMaxSquareCount = 1001;
  RequireYamlFile(request.path, request.text);
  const YAML::Node root = YAML::Load(request.text);
  if (!root.IsMap()) throw InputError("not a pattern: expected a mapping");
  Board board;
  board.kind = "star";
  const auto features = [&](const char* key) {
    return ReadCountInRange(root[key], key, kMinSquares, kMaxSquareCount) - 1;
  };
  board.columns = features("squares_x");
  board.rows = features("squares_y");
  board.segments = ReadCountInRange(root[kStarSegments], kStarSegments, 4, 64);
  board.square_m =
      FiniteNumber(root["square_length_in_meters"], "square_length_in_meters");
  const YAML::Node tags = root["apriltags"];
  if (!tags || !tags.IsSequence() || tags.size() == 0)
    throw InputError("apriltags: must list at least one tag");
  for (const YAML::Node& tag : tags)
    board.tags.push_back(
        ReadPatternTag(tag, fmt::format("apriltags[{}]", board.tags.size())));
  ExchangeContents contents;
  contents.boards.push_back(std::move(board));
  return contents;
}

}  // namespace

Format MakePuzzlepaintPatternFormat() {
  Format format;
  format.name = "puzzlepaint-pattern";
  format.holds =
      "pattern description of puzzlepaint's camera_calibration: a star board, "
      "imported as pattern.yaml";
  format.recognizes = [](const std::string& text) {
    return text.find(fmt::format("{}:", kStarSegments)) != std::string::npos;
  };
  format.read = ReadPuzzlepaintPattern;
  format.write = nullptr;
  return format;
}

}  // namespace raygrid
