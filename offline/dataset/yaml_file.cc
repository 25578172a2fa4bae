#include "dataset/yaml_file.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <sstream>
#include <vector>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

// Maximum magnitude of numbers in a file, such that squares and products remain
// finite.
constexpr double kMaxNumber = 1e12;

// Handles the events of a document and throws at duplicate keys. Aliases are
// not followed, so the time is linear in the file size.
class DuplicateKeyFinder : public YAML::EventHandler {
 public:
  explicit DuplicateKeyFinder(const std::string& path) : path_(path) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override {
    OnValue(mark, "");
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    OnValue(mark, "");
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string& value) override {
    OnValue(mark, value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&,
                       YAML::anchor_t, YAML::EmitterStyle::value) override {
    OnValue(mark, "");
    open_.push_back({});
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    OnValue(mark, "");
    is_map_ = is_map_ || open_.empty();
    open_.push_back({});
    open_.back().is_map = true;
  }
  void OnMapEnd() override { open_.pop_back(); }

  // Whether the document is a map, as camera, pattern and rig files are.
  bool is_map() const { return is_map_; }

 private:
  struct Collection {
    bool is_map = false;
    bool is_value_next = false;  // in maps: the next node is a value, not a key
    std::set<std::string> keys;
  };

  // key: empty for nodes that are not scalars.
  void OnValue(const YAML::Mark& mark, const std::string& key) {
    if (open_.empty() || !open_.back().is_map) return;
    Collection& map = open_.back();
    if (!map.is_value_next && !key.empty() && !map.keys.insert(key).second)
      throw InputError(fmt::format("{}, line {}: duplicate key '{}'", path_,
                                   mark.line + 1, Printable(key)));
    map.is_value_next = !map.is_value_next;
  }

  const std::string& path_;
  std::vector<Collection> open_;
  bool is_map_ = false;
};

// Throws if the last line is not terminated: a number or word at its end may be
// truncated.
void RequireTerminatedLastLine(const std::string& path,
                               const std::string& text) {
  const size_t last = text.find_last_not_of(" \t\r");
  if (last == std::string::npos || std::strchr("\n}]", text[last])) return;
  throw InputError(
      path +
      ": truncated within a line; use the complete file, or end the last line");
}

// Throws for an unclosed quote at the end, which yaml-cpp parses as an empty
// string.
void RequireClosedQuote(const std::string& path, const std::string& text) {
  const size_t last = text.find_last_not_of(" \t\r\n");
  if (last == std::string::npos || !std::strchr("\"'", text[last])) return;
  const size_t line = text.rfind('\n', last) + 1;
  if (std::count(text.begin() + static_cast<std::ptrdiff_t>(line), text.end(),
                 text[last]) %
          2 !=
      0)
    throw InputError(
        path + ": truncated within a quoted string; use the complete file");
}

// Throws for content after the document, which yaml-cpp otherwise ignores.
void RequireEndOfDocument(const std::string& path, YAML::Parser* parser) {
  const char* const what = "unexpected content after the end of the document";
  DuplicateKeyFinder ignored(path);
  try {
    if (!parser->HandleNextDocument(ignored)) return;
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}, line {}: {} ({}); remove it", path,
                                 error.mark.line + 1, what, error.msg));
  }
  throw InputError(fmt::format("{}: {}; remove it", path, what));
}

// Describes the position of a node; missing nodes have no line number.
std::string FormatLineNumber(const YAML::Node& node) {
  return node.IsDefined() && !node.Mark().is_null()
             ? fmt::format(" in line {}", node.Mark().line + 1)
             : "";
}

}  // namespace

void RequireYamlFile(const std::string& path, const std::string& text,
                     LastLine last_line) {
  RequireSmallTree(path, text);
  RequireTextFile(path, text);
  std::istringstream stream(text);
  DuplicateKeyFinder finder(path);
  YAML::Parser parser(stream);
  try {
    parser.HandleNextDocument(finder);
  } catch (const YAML::Exception&) {
    return;  // the caller's parser reports it
  }
  RequireEndOfDocument(path, &parser);
  RequireClosedQuote(path, text);
  if (finder.is_map() && last_line == LastLine::kIsTerminated)
    RequireTerminatedLastLine(path, text);
}

void RequireKind(const YAML::Node& root, const std::string& kind) {
  if (root.IsMap() && root["raygrid_" + kind]) return;
  const std::string is_none =
      fmt::format("not a {0} file (no 'raygrid_{0}: 1')", kind);
  static const std::vector<std::pair<std::string, std::string>> kOthers = {
      {"camera", "a camera"},
      {"pattern", "a pattern"},
      {"rectified", "a rectified pair"},
      {"rig", "a rig; use the camera.yaml of one of its cameras"}};
  for (const auto& [other, what] : kOthers)
    if (root.IsMap() && root["raygrid_" + other])
      throw InputError(is_none + ", but " + what);
  throw InputError(is_none);
}

double YamlNumber(const YAML::Node& node, const std::string& name) {
  double number = NAN;
  if (!node.IsDefined() || !YAML::convert<double>::decode(node, number) ||
      !(std::abs(number) <= kMaxNumber))
    throw InputError(fmt::format("{}{}: not a number, or larger than {:g}",
                                 name, FormatLineNumber(node), kMaxNumber));
  return number;
}

void RequireYamlList(const YAML::Node& node, const char* name, int size) {
  if (!node.IsSequence() || static_cast<int>(node.size()) != size)
    throw InputError(fmt::format("{}: expected a list of {}", name, size));
}

InputError YamlError(const std::string& path, const YAML::Exception& error) {
  const std::string position =
      error.mark.is_null()
          ? path
          : fmt::format("{}, line {}", path, error.mark.line + 1);
  return InputError(position + ": " + error.msg);
}

}  // namespace raygrid
