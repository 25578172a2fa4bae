#include "exchange/python_format.h"

#include <algorithm>
#include <cctype>

#include "exchange/file_storage.h"
#include "exchange/npz.h"
#include "exchange/opencv_cameras.h"
#include "exchange/opencv_keys.h"
#include "exchange/opencv_models.h"
#include "exchange/plain_trees.h"

namespace raygrid {
namespace {

using opencv_file::kDistortionKeys;
using opencv_file::KeyList;
using opencv_file::kMatrixKeys;
using opencv_file::ReadNamed;
using opencv_file::ReadTree;

// Converts a numeric array to nested lists; other arrays are omitted.
YAML::Node ToNestedLists(const NpyArray& array) {
  const std::vector<double> numbers = NpyNumbers(array);
  YAML::Node list(YAML::NodeType::Sequence);
  const size_t columns = array.shape.empty() ? 1 : array.shape.back();
  if (array.shape.size() < 2) {
    if (array.shape.empty()) return YAML::Node(numbers.at(0));
    for (const double number : numbers) list.push_back(number);
    return list;
  }
  for (size_t k = 0; columns > 0 && k + columns <= numbers.size();
       k += columns) {
    YAML::Node row(YAML::NodeType::Sequence);
    for (size_t c = 0; c < columns; ++c) row.push_back(numbers[k + c]);
    list.push_back(row);
  }
  return list;
}

// Converts an archive to a tree. Text and pickled objects are skipped: they
// contain no parameters.
YAML::Node MakeTree(const std::string& bytes) {
  constexpr size_t kMaxNumbers = 64;
  YAML::Node root(YAML::NodeType::Map);
  for (const NpyArray& array : ReadNpz(bytes, true)) {
    if (array.bytes.empty()) {
      root[array.name] = array.type;
      continue;
    }
    size_t count = 1;
    for (const size_t side : array.shape) count *= side;
    if (count > kMaxNumbers) continue;  // large arrays are corners or poses
    root[array.name] = ToNestedLists(array);
  }
  return root;
}

// Whether a text has a key of YAML or JSON, or for the mark '=' of TOML, with
// any prefix of a stereo pair.
bool HasKeyInText(const std::string& text, const KeyList& names, char mark) {
  const auto is_name_character = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.';
  };
  for (const std::string& name : names)
    for (size_t at = text.find(name); at != std::string::npos;
         at = text.find(name, at + 1)) {
      if (at > 0 && is_name_character(text[at - 1]) && text[at - 1] != '_' &&
          text[at - 1] != '.')
        continue;
      size_t end = at + name.size();
      // The keys of a pair have suffixes such as _left or 1.
      const size_t most = std::min(text.size(), end + 6);
      while (end < most && is_name_character(text[end])) ++end;
      if (end < text.size() && (text[end] == '"' || text[end] == '\'')) ++end;
      end = text.find_first_not_of(" \t", end);
      if (end == std::string::npos || text[end] != mark) continue;
      if (mark == ':') return true;
      end = text.find_first_not_of(" \t", end + 1);
      if (end != std::string::npos && text[end] == '[') return true;
    }
  return false;
}

// Whether a text has a camera matrix, and keys that end like those of
// coefficients or the image size.
bool HasAnyKey(const std::string& text, char mark) {
  return (HasKeyInText(text, kMatrixKeys, mark) ||
          HasKeyInText(text, {"fx"}, mark)) &&
         (HasKeyInText(text, kDistortionKeys, mark) ||
          HasKeyInText(text, {"k1"}, mark) ||
          (HasKeyInText(text, {"width", "w"}, mark) &&
           HasKeyInText(text, {"height", "h"}, mark)));
}

ExchangeContents ReadPython(const ReadRequest& request) {
  if (IsNpz(request.text)) return ReadTree(MakeTree(request.text), request);
  if (HasAnyKey(request.text, '='))
    return ReadTree(ParseToml(request.text), request);
  const YAML::Node root = ParseFileStorage(request.path, request.text);
  if (root.IsMap()) return ReadTree(root, request);
  ExchangeContents contents;
  if (root.IsSequence()) ReadNamed(root, request, 0, &contents);
  return contents;
}

}  // namespace

bool IsCameraNpz(const std::string& bytes) {
  const auto has_any = [&](const KeyList& names) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) {
                         return bytes.find(name + ".npy") != std::string::npos;
                       });
  };
  return IsNpz(bytes) && has_any(kMatrixKeys) && has_any(kDistortionKeys);
}

Format MakePythonFormat() {
  Format format;
  format.name = "python";
  format.holds =
      "Python dictionary as .json, .yaml, .toml or .npz: K, mtx or "
      "camera_matrix, and D, dist or dist_coeffs of OpenCV models, for one "
      "camera or by camera name";
  format.external_models = opencv_file::GetOpenCvModels();
  format.accepts_model = true;
  format.recognizes = [](const std::string& text) {
    if (IsNpz(text)) return IsCameraNpz(text);
    for (const Format& other : GetFormats())  // more specific formats take
                                              // precedence
      if (other.name != "python" && other.recognizes(text)) return false;
    return HasAnyKey(text, ':') || HasAnyKey(text, '=');
  };
  format.read = ReadPython;
  format.write = nullptr;
  return format;
}

}  // namespace raygrid
