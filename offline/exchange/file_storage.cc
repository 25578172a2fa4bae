#include "exchange/file_storage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/xml.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kMatrixType[] = "opencv-matrix",
               kArrayType[] = "opencv-nd-matrix";
constexpr char kXmlRoot[] = "opencv_storage";

bool IsXml(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] == '<';
}

// Splits a leaf's text at white space. Quoted words, which may contain white
// space, end at a quote before white space.
std::vector<std::string> SplitTokens(const std::string& text) {
  constexpr char kSpaces[] = " \t\r\n";
  std::vector<std::string> words;
  size_t at = 0;
  while ((at = text.find_first_not_of(kSpaces, at)) != std::string::npos) {
    const bool is_quoted = text[at] == '"';
    const size_t first = is_quoted ? at + 1 : at;
    size_t end = std::min(text.find_first_of(kSpaces, first), text.size());
    while (is_quoted && end < text.size() && text[end - 1] != '"')
      end = std::min(text.find_first_of(kSpaces, end + 1), text.size());
    const bool is_closed = is_quoted && end > first && text[end - 1] == '"';
    words.push_back(text.substr(first, end - first - (is_closed ? 1 : 0)));
    at = end;
  }
  return words;
}

YAML::Node MakeLeafNode(const std::string& text) {
  const std::vector<std::string> words = SplitTokens(text);
  if (words.size() == 1) return YAML::Node(words[0]);
  YAML::Node list(YAML::NodeType::Sequence);
  for (const std::string& word : words) list.push_back(word);
  return list;
}

YAML::Node MakeNode(const XmlElement& element) {
  if (element.children.empty()) {
    const YAML::Node leaf = MakeLeafNode(element.text);
    // <data> with one number is still a list.
    if (element.name != "data" || leaf.IsSequence()) return leaf;
    YAML::Node list(YAML::NodeType::Sequence);
    list.push_back(leaf);
    return list;
  }
  YAML::Node node;
  std::set<std::string> names;
  for (const XmlElement& child : element.children) {
    if (child.name == "_") {
      node.push_back(MakeNode(child));
      continue;
    }
    if (!names.insert(child.name).second)
      throw InputError(fmt::format("line {}: duplicate key '{}'", child.line,
                                   Printable(child.name)));
    node.force_insert(child.name, MakeNode(child));
  }
  return node;
}

// Whether a YAML line lacks the space between key and value: "data:[ 1 ]",
// "PointSize:2". Keys have at least two letters.
bool LacksSpaceAfterColon(const std::string& line, size_t* colon) {
  const size_t first = line.find_first_not_of(" \t");
  if (first == std::string::npos ||
      !std::isalpha(static_cast<unsigned char>(line[first])))
    return false;
  *colon = first;
  while (*colon < line.size() &&
         (std::isalnum(static_cast<unsigned char>(line[*colon])) ||
          std::strchr("_.-", line[*colon])))
    ++*colon;
  return *colon > first + 1 && *colon + 1 < line.size() &&
         line[*colon] == ':' && !std::strchr(" \t\r/:", line[*colon + 1]);
}

// Converts FileStorage's YAML dialect to standard YAML: its version line
// becomes a comment, and a space is inserted after a key where it is missing.
std::string StorageAsYaml(std::string text) {
  if (text.rfind("%YAML:", 0) != 0) return text;
  text[0] = '#';
  std::string yaml;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    std::string line = text.substr(at, end - at);
    size_t colon = 0;
    if (LacksSpaceAfterColon(line, &colon)) line.insert(colon + 1, " ");
    yaml += line;
    at = end;
  }
  return yaml;
}

// Removes comment lines, which some JSON parsers accept.
std::string RemoveComments(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos ||
      (text[first] != '{' && text[first] != '/') ||
      text.find("//") == std::string::npos)
    return text;
  std::string json;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    const size_t word = text.find_first_not_of(" \t", at);
    json += word != std::string::npos && text.compare(word, 2, "//") == 0
                ? "\n"
                : text.substr(at, end - at);
    at = end;
  }
  return json;
}

// Reads a list of numbers, which is one row, or a list of rows.
StoredMatrix MakeMatrix(const YAML::Node& node, const std::string& name) {
  StoredMatrix matrix;
  matrix.data = AllNumbers(node, name);
  const bool has_rows = node.size() > 0 && node[0].IsSequence();
  matrix.rows = has_rows ? static_cast<int>(node.size()) : 1;
  matrix.columns = static_cast<int>(has_rows ? node[0].size() : node.size());
  if (matrix.data.size() !=
      static_cast<size_t>(matrix.rows) * static_cast<size_t>(matrix.columns))
    throw InputError(fmt::format("{}: rows have different lengths", name));
  return matrix;
}

std::string QuoteText(FileStorageText::Kind kind, const std::string& text) {
  if (kind != FileStorageText::Kind::kXml) return QuotedYaml(text);
  std::string quoted = "\"";
  for (const char c : Printable(text))
    quoted += c == '<'   ? "&lt;"
              : c == '>' ? "&gt;"
              : c == '&' ? "&amp;"
              : c == '"' ? "&quot;"
                         : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

bool IsFileStorage(const std::string& text) {
  return text.find(kMatrixType) != std::string::npos ||
         text.find(kArrayType) != std::string::npos ||
         text.find(kXmlRoot) != std::string::npos;
}

YAML::Node ParseFileStorage(const std::string& path, const std::string& text) {
  if (IsXml(text)) {
    RequireSmallTree("", text, " \t\n");  // numbers have no other separators
    const XmlElement root = ParseXml(text);
    if (root.name != kXmlRoot)
      throw InputError(fmt::format("the root element is '{}', not '{}'",
                                   Printable(root.name), kXmlRoot));
    return MakeNode(root);
  }
  const std::string yaml = RemoveComments(StorageAsYaml(text));
  RequireYamlFile(path, yaml, LastLine::kMayBeUnterminated);
  return YAML::Load(yaml);
}

StoredMatrix ParseStoredMatrix(const YAML::Node& node, const std::string& name,
                               int num_channels) {
  if (node.IsDefined() && node.IsSequence() && num_channels == 1)
    return MakeMatrix(node, name);
  if (!node.IsMap() || !node["cols"] || !node["data"])
    throw InputError(fmt::format("{}: expected a matrix", name));
  // "d", or "2f" for two channels.
  const std::string type = node["dt"] ? node["dt"].as<std::string>() : "d";
  if (type.substr(0, type.size() - 1) !=
      (num_channels == 1 ? "" : std::to_string(num_channels)))
    throw InputError(fmt::format("{}: expected {} channel{}", name,
                                 num_channels, num_channels == 1 ? "" : "s"));
  StoredMatrix matrix;
  // OpenCalib's lists lack the number of rows; its matrices are lists of rows.
  matrix.rows = node["rows"] ? SidePx(node["rows"], name + ": rows") : 1;
  matrix.columns = SidePx(node["cols"], name + ": cols");
  matrix.data = AllNumbers(node, name);
  if (matrix.data.size() != static_cast<size_t>(matrix.rows) *
                                static_cast<size_t>(matrix.columns) *
                                static_cast<size_t>(num_channels))
    throw InputError(fmt::format("{}: {} numbers do not match the size {} x {}",
                                 name, matrix.data.size(), matrix.rows,
                                 matrix.columns * num_channels));
  return matrix;
}

StoredMatrix ParseStoredPoints(const YAML::Node& node,
                               const std::string& name) {
  if (!node.IsMap() || !node["sizes"]) return ParseStoredMatrix(node, name, 2);
  // The first dimension is the number of images; the second, after removal of
  // dimensions of size 1, the number of points per image.
  std::vector<int> sizes;
  for (const YAML::Node& size : node["sizes"])
    sizes.push_back(SidePx(size, name + ": sizes"));
  if (node["dt"] && node["dt"].as<std::string>()[0] == '2') sizes.push_back(2);
  StoredMatrix points;
  points.data = FiniteNumbers(node["data"], name);
  if (!sizes.empty()) {
    points.rows = sizes.front();
    sizes.erase(sizes.begin());
    sizes.erase(std::remove(sizes.begin(), sizes.end(), 1), sizes.end());
  }
  if (sizes.size() != 2 || sizes[1] != 2)
    throw InputError(
        fmt::format("{}: expected images x points x 2 numbers", name));
  points.columns = sizes[0];
  if (points.data.size() != 2 * static_cast<size_t>(points.rows) *
                                static_cast<size_t>(points.columns))
    throw InputError(
        fmt::format("{}: {} numbers do not match the size {} x {} x 2", name,
                    points.data.size(), points.rows, points.columns));
  return points;
}

FileStorageText::Kind FileStorageText::KindOf(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension();
  if (ending == ".xml") return Kind::kXml;
  return ending == ".json" ? Kind::kJson : Kind::kYaml;
}

FileStorageText::FileStorageText(Kind kind) : kind_(kind) {
  text_ = kind == Kind::kYaml ? "%YAML:1.0\n---\n"
          : kind == Kind::kXml
              ? fmt::format("<?xml version=\"1.0\"?>\n<{}>\n", kXmlRoot)
              : "{\n";
}

std::string FileStorageText::Indentation() const {
  const size_t depth = open_.size() + (kind_ == Kind::kJson ? 1 : 0);
  return std::string(3 * depth, ' ');
}

void FileStorageText::AddPlain(const std::string& key,
                               const std::string& value) {
  switch (kind_) {
    case Kind::kYaml:
      text_ += fmt::format("{}{}: {}\n", Indentation(), key, value);
      break;
    case Kind::kXml:
      text_ += fmt::format("{0}<{1}>{2}</{1}>\n", Indentation(), key, value);
      break;
    case Kind::kJson:
      text_ += fmt::format("{}\"{}\": {},\n", Indentation(), key, value);
      break;
  }
}

void FileStorageText::Add(const std::string& key, int number) {
  AddPlain(key, std::to_string(number));
}

void FileStorageText::Add(const std::string& key, double number) {
  AddPlain(key, FormatReal(number));
}

void FileStorageText::Add(const std::string& key, const std::string& text) {
  AddPlain(key, QuoteText(kind_, text));
}

void FileStorageText::Add(const std::string& key, const StoredMatrix& matrix) {
  std::string numbers = RealTexts(matrix.data);
  switch (kind_) {
    case Kind::kYaml:
      text_ += fmt::format(
          "{0}{1}: !!{2}\n{0}   rows: {3}\n{0}   cols: {4}\n{0}   dt: d\n"
          "{0}   data: [ {5} ]\n",
          Indentation(), key, kMatrixType, matrix.rows, matrix.columns,
          numbers);
      break;
    case Kind::kXml:
      numbers.erase(std::remove(numbers.begin(), numbers.end(), ','),
                    numbers.end());
      text_ += fmt::format(
          "{0}<{1} type_id=\"{2}\">\n{0}   <rows>{3}</rows>\n"
          "{0}   <cols>{4}</cols>\n{0}   <dt>d</dt>\n"
          "{0}   <data>{5}</data></{1}>\n",
          Indentation(), key, kMatrixType, matrix.rows, matrix.columns,
          numbers);
      break;
    case Kind::kJson:
      text_ += fmt::format(
          "{0}\"{1}\": {{\n{0}   \"type_id\": \"{2}\",\n{0}   \"rows\": {3},\n"
          "{0}   \"cols\": {4},\n{0}   \"dt\": \"d\",\n"
          "{0}   \"data\": [ {5} ]\n{0}}},\n",
          Indentation(), key, kMatrixType, matrix.rows, matrix.columns,
          numbers);
      break;
  }
}

void FileStorageText::Add(const std::string& key,
                          const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts)
    list += (list.empty()          ? ""
             : kind_ == Kind::kXml ? " "
                                   : ", ") +
            QuoteText(kind_, text);
  AddPlain(key, kind_ == Kind::kXml ? list : "[ " + list + " ]");
}

void FileStorageText::BeginMap(const std::string& key) {
  text_ += kind_ == Kind::kYaml ? fmt::format("{}{}:\n", Indentation(), key)
           : kind_ == Kind::kXml
               ? fmt::format("{}<{}>\n", Indentation(), key)
               : fmt::format("{}\"{}\": {{\n", Indentation(), key);
  open_.push_back(key);
}

void FileStorageText::EndMap() {
  const std::string key = open_.back();
  open_.pop_back();
  if (kind_ == Kind::kXml)
    text_ += fmt::format("{}</{}>\n", Indentation(), key);
  if (kind_ != Kind::kJson) return;
  text_.resize(text_.size() - 2);  // removes the comma after the last value
  text_ += fmt::format("\n{}}},\n", Indentation());
}

std::string FileStorageText::Finish() {
  if (kind_ == Kind::kXml) return text_ + fmt::format("</{}>\n", kXmlRoot);
  if (kind_ == Kind::kYaml) return text_;
  text_.resize(text_.size() - 2);
  return text_ + "\n}\n";
}

}  // namespace raygrid
