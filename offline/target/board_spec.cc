#include "target/board_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>

#include "dataset/error.h"
#include "target/board_yaml.h"
#include "target/marker_boards.h"

namespace raygrid {
namespace {

[[noreturn]] void ThrowInvalidSpec(const std::string& reason) {
  throw Error(ExitCode::kUsage, reason);
}

// Parses the number at the start of a text and removes it from the text.
template <typename T>
bool ExtractNumber(std::string* text, T* value) {
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
  if (ExtractNumber(&text, &value) && value > 0) {
    if (text == "mm") return value / 1000;
    if (text == "cm") return value / 100;
    if (text == "m") return value;
  }
  ThrowInvalidSpec(fmt::format(
      "'{}' is not a length; specify a number with unit, such as 25mm", given));
}

// Splits the specification at colons; NAME=VALUE options are parsed when
// requested.
class Spec : public BoardOptions {
 public:
  explicit Spec(const std::string& text) {
    std::vector<std::string> parts;
    for (size_t begin = 0; begin <= text.size();) {
      const size_t end = std::min(text.find(':', begin), text.size());
      parts.push_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
    if (parts.size() < 3)
      ThrowInvalidSpec(
          "neither a file nor a target specification, "
          "KIND:COLUMNSxROWS:LENGTH, such as chessboard:9x6:25mm");
    kind = parts[0];
    ParseSize(parts[1]);
    length_m = LengthM(parts[2]);
    for (size_t i = 3; i < parts.size(); ++i) {
      const size_t equals = std::min(parts[i].find('='), parts[i].size());
      const std::string name = parts[i].substr(0, equals);
      if (!values_
               .emplace(name, equals < parts[i].size()
                                  ? parts[i].substr(equals + 1)
                                  : "")
               .second)
        ThrowInvalidSpec(fmt::format("duplicate '{}'", name));
    }
  }

  void Number(const char* name, const char*, int* value) override {
    ExtractValue(name, value);
  }

  void Number(const char* name, const char*, double* value) override {
    ExtractValue(name, value);
  }

  void Number(const char* name, const char*, int,
              std::optional<int>* value) override {
    if (values_.count(name) != 0) ExtractValue(name, &value->emplace());
  }

  void Text(const char* name, const char*, std::string* value) override {
    *value = Text(name, *value);
  }

  void Word(const char* name, const char*,
            const std::vector<std::string>& words,
            std::optional<std::string>* value) override {
    const std::string word = Text(name, "");
    if (word.empty()) return;
    if (std::find(words.begin(), words.end(), word) == words.end())
      ThrowInvalidSpec(fmt::format("{}={}: expected {}", name, word,
                                   fmt::join(words, " or ")));
    *value = word;
  }

  void Flag(const char* name, const char*, bool* value) override {
    const auto found = values_.find(name);
    if (found == values_.end()) return;
    if (!found->second.empty())
      ThrowInvalidSpec(fmt::format("'{}' does not take a value", name));
    values_.erase(found);
    *value = true;
  }

  void Length(const char* name, const char*, double* value_mm) override {
    const std::string length = Text(name, "");
    if (length.empty())
      ThrowInvalidSpec(
          fmt::format("missing {0} size, such as {0}=21mm (side of the black "
                      "square)",
                      name));
    *value_mm = 1000 * LengthM(length);
  }

  void RequireAllUsed() const {
    if (!values_.empty())
      ThrowInvalidSpec(fmt::format("{} does not support '{}'", kind,
                                   values_.begin()->first));
  }

  std::string kind;
  int columns = 0, rows = 0;
  double length_m = 0;

 private:
  std::string Text(const std::string& name, const std::string& otherwise) {
    const auto found = values_.find(name);
    if (found == values_.end()) return otherwise;
    const std::string value = found->second;
    values_.erase(found);
    if (value.empty())
      ThrowInvalidSpec(fmt::format("'{}' requires a value", name));
    return value;
  }

  template <typename T>
  void ExtractValue(const char* name, T* value) {
    if (values_.count(name) == 0) return;
    std::string text = Text(name, "");
    const std::string given = text;
    if (!ExtractNumber(&text, value) || !text.empty())
      ThrowInvalidSpec(fmt::format("{}={}: invalid number", name, given));
  }

  void ParseSize(std::string text) {
    const std::string given = text;
    const bool has_columns = ExtractNumber(&text, &columns);
    if (has_columns && !text.empty() && text[0] == 'x') {
      text.erase(0, 1);
      if (ExtractNumber(&text, &rows) && text.empty() && columns > 0 &&
          rows > 0)
        return;
    }
    ThrowInvalidSpec(fmt::format(
        "'{}' is not a size; expected COLUMNSxROWS, such as 9x6", given));
  }

  std::map<std::string, std::string> values_;
};

std::vector<Board> MakeBoardList(Spec* spec) {
  const TargetKind& kind = KindOf(spec->kind);
  if (!kind.is_drawable)
    ThrowInvalidSpec(
        fmt::format("neither a file nor a known target kind: '{}'; use {}, or "
                    "a pattern.yaml",
                    spec->kind, DrawableKinds()));
  BoardRequest request;
  request.board.columns = spec->columns;
  request.board.rows = spec->rows;
  request.length_mm = 1000 * spec->length_m;
  if (kind.max_count > 0 &&
      std::max(spec->columns, spec->rows) > kind.max_count)
    ThrowInvalidSpec(fmt::format("at most {} {} per side are supported",
                                 kind.max_count, kind.counted_name));
  kind.AddOptions(spec, &request);
  spec->RequireAllUsed();
  return MakeBoards(kind, request);
}

}  // namespace

Pattern ParseBoardSpec(const std::string& text) {
  try {
    Spec spec(text);
    return ParsePattern(text, MakeBoardsYaml(MakeBoardList(&spec)));
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
