#include "target/board_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>

#include "dataset/error.h"
#include "target/board_yaml.h"
#include "target/marker_boards.h"
#include "target/star_boards.h"

namespace raygrid {
namespace {

[[noreturn]] void Refuse(const std::string& reason) {
  throw Error(ExitCode::kUsage, reason);
}

// The number that a text begins with, and what follows it.
template <typename T>
bool TakeNumber(std::string* text, T* value) {
  const char* const begin = text->data();
  const auto [end, error] =
      std::from_chars(begin, begin + text->size(), *value);
  if (error != std::errc()) return false;
  text->erase(0, end - begin);
  return true;
}

double LengthM(std::string text) {
  const std::string given = text;
  double value = 0;
  if (TakeNumber(&text, &value) && value > 0) {
    if (text == "mm") return value / 1000;
    if (text == "cm") return value / 100;
    if (text == "m") return value;
  }
  Refuse(fmt::format(
      "'{}' is not a length; specify a number with unit, such as 25mm", given));
}

// The parts between the colons, and NAME=VALUE as they are asked for.
class Spec {
 public:
  explicit Spec(const std::string& text) {
    std::vector<std::string> parts;
    for (size_t begin = 0; begin <= text.size();) {
      const size_t end = std::min(text.find(':', begin), text.size());
      parts.push_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
    if (parts.size() < 3)
      Refuse(
          "neither a file nor a target specification, "
          "KIND:COLUMNSxROWS:LENGTH, such as chessboard:9x6:25mm");
    kind = parts[0];
    TakeSize(parts[1]);
    length_m = LengthM(parts[2]);
    for (size_t i = 3; i < parts.size(); ++i) {
      const size_t equals = std::min(parts[i].find('='), parts[i].size());
      const std::string name = parts[i].substr(0, equals);
      if (!values_
               .emplace(name, equals < parts[i].size()
                                  ? parts[i].substr(equals + 1)
                                  : "")
               .second)
        Refuse(fmt::format("duplicate '{}'", name));
    }
  }

  std::string Text(const std::string& name, const std::string& otherwise) {
    const auto found = values_.find(name);
    if (found == values_.end()) return otherwise;
    const std::string value = found->second;
    values_.erase(found);
    if (value.empty()) Refuse(fmt::format("'{}' requires a value", name));
    return value;
  }

  template <typename T>
  T Number(const std::string& name, T otherwise) {
    std::string text = Text(name, fmt::format("{}", otherwise));
    const std::string given = text;
    T value = otherwise;
    if (!TakeNumber(&text, &value) || !text.empty())
      Refuse(fmt::format("{}={}: invalid number", name, given));
    return value;
  }

  bool Flag(const std::string& name) {
    const auto found = values_.find(name);
    if (found == values_.end()) return false;
    if (!found->second.empty())
      Refuse(fmt::format("'{}' does not take a value", name));
    values_.erase(found);
    return true;
  }

  void RequireAllAsked() const {
    if (!values_.empty())
      Refuse(fmt::format("{} does not support '{}'", kind,
                         values_.begin()->first));
  }

  std::string kind;
  int columns = 0, rows = 0;
  double length_m = 0;

 private:
  void TakeSize(std::string text) {
    const std::string given = text;
    const bool has_columns = TakeNumber(&text, &columns);
    if (has_columns && !text.empty() && text[0] == 'x') {
      text.erase(0, 1);
      if (TakeNumber(&text, &rows) && text.empty() && columns > 0 && rows > 0)
        return;
    }
    Refuse(fmt::format("'{}' is not a size; expected COLUMNSxROWS, such as 9x6",
                       given));
  }

  std::map<std::string, std::string> values_;
};

std::vector<Board> StarsOf(Spec* spec) {
  StarBoardOptions options;
  options.columns = spec->columns;
  options.rows = spec->rows;
  options.square_mm = 1000 * spec->length_m;
  options.segments = spec->Number("segments", options.segments);
  options.num_tags = spec->Number("tags", options.num_tags);
  options.tag_id = spec->Number("tag-id", options.tag_id);
  options.tag_squares = spec->Number("tag-squares", options.tag_squares);
  options.num_boards = spec->Number("boards", options.num_boards);
  spec->RequireAllAsked();
  return StarBoards(options);
}

std::vector<Board> MarkersOf(Board board, Spec* spec) {
  board.first_marker = spec->Number("first-marker", 0);
  const int num_boards = spec->Number("boards", 1);
  spec->RequireAllAsked();
  return MarkerBoards(board, num_boards);
}

std::vector<Board> CharucoOf(Board board, Spec* spec) {
  const std::string marker = spec->Text("marker", "");
  if (marker.empty())
    Refuse(
        "missing marker size, such as marker=21mm (side of the black square)");
  board.marker_m = LengthM(marker);
  board.dictionary = spec->Text("dictionary", "DICT_4X4_50");
  board.is_legacy = spec->Flag("legacy");
  return MarkersOf(board, spec);
}

std::vector<Board> AprilGridOf(Board board, Spec* spec) {
  constexpr int kMaxTags = 500;
  if (std::max(board.columns, board.rows) > kMaxTags)
    Refuse(fmt::format("at most {} tags per side are supported", kMaxTags));
  board.columns *= 2;  // features: two for each tag
  board.rows *= 2;
  board.tag_family = spec->Text("family", "tag36h11");
  board.spacing_ratio = spec->Number("spacing-ratio", 0.3);
  SetCornerSquares(!spec->Flag("no-squares"), &board);
  board.border_cells = spec->Number("border-cells", board.border_cells);
  const std::string from = spec->Text(
      "numbered-from", board.is_numbered_from_top ? "top" : "bottom");
  if (from != "top" && from != "bottom")
    Refuse(fmt::format("numbered-from={}: expected top or bottom", from));
  board.is_numbered_from_top = from == "top";
  return MarkersOf(board, spec);
}

std::vector<Board> BoardsOf(Spec* spec) {
  if (spec->kind == "star") return StarsOf(spec);
  Board board;
  board.kind = spec->kind;
  board.columns = spec->columns;
  board.rows = spec->rows;
  board.square_m = spec->length_m;
  if (spec->kind == "charuco") return CharucoOf(board, spec);
  if (spec->kind == "aprilgrid") return AprilGridOf(board, spec);
  if (spec->kind != "chessboard")
    Refuse(
        fmt::format("neither a file nor a known target kind: '{}'; use "
                    "chessboard, charuco, aprilgrid or star, or a pattern.yaml",
                    spec->kind));
  spec->RequireAllAsked();
  RequirePossibleBoards({board});
  return {board};
}

}  // namespace

Pattern ParseBoardSpec(const std::string& text) {
  try {
    Spec spec(text);
    return ParsePattern(text, BoardsYaml(BoardsOf(&spec)));
  } catch (const Error& error) {
    throw Error(ExitCode::kUsage, fmt::format("{}: {}", text, error.what()));
  }
}

bool IsBoardSpec(const std::string& path_or_spec) {
  std::error_code ignored;
  return path_or_spec.find(':') != std::string::npos &&
         !std::filesystem::exists(path_or_spec, ignored);
}

Pattern ReadPatternOrSpec(const std::string& path_or_spec) {
  return IsBoardSpec(path_or_spec) ? ParseBoardSpec(path_or_spec)
                                   : ReadPattern(path_or_spec);
}

}  // namespace raygrid
