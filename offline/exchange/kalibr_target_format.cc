#include "exchange/kalibr_target_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kTargetType[] = "target_type";

bool IsKalibrTarget(const std::string& text) {
  return text.find(fmt::format("{}:", kTargetType)) != std::string::npos;
}

// Maximum number of rows or columns of target features.
constexpr int kMaxAlongSide = 1000;

int ReadCount(const YAML::Node& root, const char* key, int features) {
  const double count = FiniteNumber(root[key], key);
  if (!(count >= 1 && count * features <= kMaxAlongSide) ||
      count != std::floor(count))
    throw InputError(fmt::format("{}: expected an integer from 1 to {}", key,
                                 kMaxAlongSide / features));
  return static_cast<int>(count);
}

double ReadLength(const YAML::Node& root, const char* key) {
  const double length = FiniteNumber(root[key], key);
  if (!(length > 0)) throw InputError(fmt::format("{}: must be positive", key));
  return length;
}

Board ReadAprilGrid(const YAML::Node& root) {
  Board board;
  board.kind = "aprilgrid";
  board.columns = 2 * ReadCount(root, "tagCols", 2);
  board.rows = 2 * ReadCount(root, "tagRows", 2);
  board.square_m = ReadLength(root, "tagSize");
  board.spacing_ratio = ReadLength(root, "tagSpacing");
  board.tag_family = "tag36h11";
  return board;
}

// Kalibr counts inner corners. Boards with different row and column spacing
// become point sets.
Board ReadCheckerboard(const YAML::Node& root) {
  Board board;
  board.kind = "chessboard";
  board.columns = ReadCount(root, "targetCols", 1);
  board.rows = ReadCount(root, "targetRows", 1);
  const double x = ReadLength(root, "colSpacingMeters"),
               y = ReadLength(root, "rowSpacingMeters");
  board.square_m = (x + y) / 2;
  if (x == y) return board;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      board.points.emplace_back(column * x, row * y, 0);
  return board;
}

ExchangeContents ReadKalibrTarget(const ReadRequest& request) {
  RequireYamlFile(request.path, request.text);
  const YAML::Node root = YAML::Load(request.text);
  if (!root.IsMap()) throw InputError("not a target: expected a mapping");
  const std::string type =
      root[kTargetType].IsScalar() ? root[kTargetType].as<std::string>() : "";
  ExchangeContents contents;
  if (type == "aprilgrid")
    contents.boards.push_back(ReadAprilGrid(root));
  else if (type == "checkerboard")
    contents.boards.push_back(ReadCheckerboard(root));
  else
    throw InputError(fmt::format(
        "unsupported {} '{}'; supported are aprilgrid and checkerboard",
        kTargetType, Printable(type)));
  return contents;
}

}  // namespace

Format MakeKalibrTargetFormat() {
  Format format;
  format.name = "kalibr-target";
  format.holds =
      "target.yaml of Kalibr: an aprilgrid or a checkerboard, imported as "
      "pattern.yaml";
  format.recognizes = IsKalibrTarget;
  format.read = ReadKalibrTarget;
  format.write = nullptr;
  return format;
}

}  // namespace raygrid
