#include "dataset/yaml_file.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <set>
#include <sstream>
#include <vector>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

// Hears what a document consists of, and throws at the second key of a name.
// Aliases are not followed, so the work grows with the file alone.
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
    open_.push_back({});
    open_.back().is_map = true;
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  struct Collection {
    bool is_map = false;
    bool is_value_next = false;  // in a map; else a key
    std::set<std::string> keys;
  };

  // key is empty for what is no scalar.
  void OnValue(const YAML::Mark& mark, const std::string& key) {
    if (open_.empty() || !open_.back().is_map) return;
    Collection& map = open_.back();
    if (!map.is_value_next && !key.empty() && !map.keys.insert(key).second)
      throw InputError(
          fmt::format("{}, line {}: the key '{}' stands twice; keep one", path_,
                      mark.line + 1, Printable(key)));
    map.is_value_next = !map.is_value_next;
  }

  const std::string& path_;
  std::vector<Collection> open_;
};

}  // namespace

void RequireYamlFile(const std::string& path, const std::string& text) {
  RequireTextFile(path, text);
  std::istringstream stream(text);
  DuplicateKeyFinder finder(path);
  try {
    YAML::Parser(stream).HandleNextDocument(finder);
  } catch (const YAML::Exception&) {
    // Parsing it says what is wrong.
  }
}

}  // namespace raygrid
