#include "exchange/plain_trees.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>
#include <vector>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

std::string RemoveSpaces(const std::string& text) {
  constexpr char kSpaces[] = " \t\r\n";
  const size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

[[noreturn]] void ThrowInLine(int line, const std::string& fault) {
  throw InputError(fmt::format("line {}: {}", line, fault));
}

void RequireText(const std::string& text) {
  RequireSmallTree("", text, "\n,:[{? \t");
  if (FindInvalidUtf8(text) != std::string::npos)
    throw InputError("not UTF-8 text");
}

// Removes the comment of a line and counts the brackets that remain open.
std::string RemoveComment(const std::string& line, int* depth) {
  char quote = 0;
  for (size_t k = 0; k < line.size(); ++k) {
    const char c = line[k];
    if (quote) {
      quote = c == quote ? 0 : quote;
      continue;
    }
    if (c == '"' || c == '\'') quote = c;
    if (c == '[' || c == '{') ++*depth;
    if (c == ']' || c == '}') --*depth;
    if (c == '#') return line.substr(0, k);
  }
  return line;
}

std::string RemoveQuotes(const std::string& key) {
  const bool is_quoted = key.size() >= 2 && (key[0] == '"' || key[0] == '\'') &&
                         key.back() == key[0];
  return is_quoted ? key.substr(1, key.size() - 2) : key;
}

// TOML values are valid YAML flow values; YAML also accepts TOML's trailing
// comma in lists.
YAML::Node TomlValue(const std::string& text, int line) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    ThrowInLine(line, error.msg);
  }
}

// A map with fast insertion: yaml-cpp searches keys linearly, which is slow in
// large maps.
class YamlMapBuilder {
 public:
  YamlMapBuilder() = default;
  // Copies would alias: yaml-cpp nodes have reference semantics.
  YamlMapBuilder(const YamlMapBuilder&) = delete;
  YamlMapBuilder& operator=(const YamlMapBuilder&) = delete;

  void Add(const std::string& key, const YAML::Node& value, int line) {
    if (key.empty()) ThrowInLine(line, "missing key");
    if (!keys_.insert(key).second)
      ThrowInLine(line, fmt::format("duplicate key '{}'", Printable(key)));
    node_.force_insert(key, value);
  }
  bool Has(const std::string& key) const { return keys_.count(key) > 0; }
  const YAML::Node& node() const { return node_; }

 private:
  YAML::Node node_ = YAML::Node(YAML::NodeType::Map);
  std::set<std::string> keys_;
};

}  // namespace

YAML::Node ParseToml(const std::string& text) {
  RequireText(text);
  YamlMapBuilder root;
  std::optional<YamlMapBuilder> table;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const int first = number;
    int depth = 0;
    std::string statement = RemoveSpaces(RemoveComment(line, &depth));
    if (statement.empty()) continue;
    const size_t equals = statement.find('=');
    if (statement[0] == '[') {
      if (statement.back() != ']' || statement[1] == '[')
        ThrowInLine(number,
                    "expected a table; arrays of tables are not supported");
      table.emplace();
      root.Add(
          RemoveQuotes(RemoveSpaces(statement.substr(1, statement.size() - 2))),
          table->node(), number);
      continue;
    }
    if (equals == std::string::npos)
      ThrowInLine(number, "expected 'KEY = VALUE'");
    while (depth > 0 && std::getline(lines, line)) {
      statement += " " + RemoveSpaces(RemoveComment(line, &depth));
      ++number;
    }
    if (depth != 0) ThrowInLine(first, "unclosed bracket");
    (table ? *table : root)
        .Add(RemoveQuotes(RemoveSpaces(statement.substr(0, equals))),
             TomlValue(statement.substr(equals + 1), first), first);
  }
  return root.node();
}

YAML::Node ParseKeyLines(const std::string& text, char mark) {
  RequireText(text);
  YamlMapBuilder root;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (mark == '=') {  // MATLAB: brackets, terminators and comments
      line.resize(std::min(line.find('%'), line.size()));
      std::replace_if(
          line.begin(), line.end(),
          [](char c) { return c == '[' || c == ']' || c == ';' || c == ','; },
          ' ');
    }
    const std::string stripped_line = RemoveSpaces(line);
    if (stripped_line.empty() || stripped_line[0] == '#') continue;
    const size_t colon = line.find(mark);
    if (colon == std::string::npos)
      ThrowInLine(number, fmt::format("expected 'KEY{} NUMBERS'", mark));
    YAML::Node list(YAML::NodeType::Sequence);
    std::istringstream words(line.substr(colon + 1));
    for (std::string word; words >> word;) list.push_back(word);
    root.Add(RemoveSpaces(line.substr(0, colon)),
             list.size() == 1 ? YAML::Node(list[0].as<std::string>()) : list,
             number);
  }
  return root.node();
}

YAML::Node ParseBlocks(const std::string& text) {
  RequireText(text);
  YAML::Node root(YAML::NodeType::Map);
  int number = 0;
  bool is_open = false;
  YAML::Node block(YAML::NodeType::Sequence);
  std::istringstream lines(text + "\n\n");
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    size_t count = 0;
    for (std::string word; words >> word; ++count) block.push_back(word);
    if (count == 0 && is_open) {
      root.force_insert(std::to_string(number++), block);
      block.reset(YAML::Node(YAML::NodeType::Sequence));
    }
    is_open = count > 0;
  }
  return root;
}

YAML::Node ParseRosIni(const std::string& text) {
  RequireText(text);
  YamlMapBuilder root;
  std::istringstream lines(text);
  std::string line, section, key;
  YAML::Node list(YAML::NodeType::Sequence);
  const auto finish = [&](int number) {
    if (key.empty()) return;
    const bool is_side = section == "image" && list.size() == 1;
    root.Add(
        key,
        is_side ? YAML::Node(list[0].as<std::string>()) : YAML::Clone(list),
        number);
    key.clear();
  };
  int number = 1;
  for (; std::getline(lines, line); ++number) {
    const std::string words = RemoveSpaces(line);
    if (words.empty() || words[0] == '#') continue;
    if (words[0] == '[') {
      finish(number);
      section = RemoveSpaces(words.substr(1, words.find(']') - 1));
      if (section != "image" && section != "externals" && !root.Has("name"))
        root.Add("name", YAML::Node(section), number);
    } else if (words.find_first_not_of("0123456789.+-eE \t") ==
               std::string::npos) {
      std::istringstream numbers(words);
      for (std::string word; numbers >> word;) list.push_back(word);
    } else {
      finish(number);
      key = words;
      list = YAML::Node(YAML::NodeType::Sequence);
    }
  }
  finish(number);
  return root.node();
}

}  // namespace raygrid
