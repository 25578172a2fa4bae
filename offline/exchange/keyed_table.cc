#include "exchange/keyed_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>

#include "exchange/opencv_model_list.h"
#include "exchange/radial_model.h"

namespace raygrid {
namespace {

constexpr char kFormats[] =
#include "exchange/keyed_formats.inc"
    ;

// ---- Recognition -----------------------------------------------------------

// Whether a text has, for two cameras, three lines of 2 numbers each, and then
// three lines of 4 numbers.
bool IsInfiniTam(const std::string& text) {
  constexpr size_t kMaxBytes = 2000;
  if (text.size() > kMaxBytes) return false;
  std::istringstream lines(text);
  std::string counts;
  for (std::string line; std::getline(lines, line) && counts.size() < 9;) {
    std::istringstream words(line);
    size_t count = 0;
    for (double number = 0; words >> number;) ++count;
    if (count > 0 && words.eof()) counts += std::to_string(count);
  }
  return counts == "222222444";
}

// Whether a text is one line of 4, 8 or 9 numbers.
bool IsNumberLine(const std::string& text) {
  constexpr size_t kMaxBytes = 400;
  if (text.size() > kMaxBytes) return false;
  const std::string line = FindNumberLine(text);
  if (line.find_first_not_of("0123456789.+-eE \t\r") != std::string::npos)
    return false;
  std::istringstream words(line);
  size_t count = 0;
  for (double number = 0; words >> number;) ++count;
  return words.eof() && (count == 4 || count == 8 || count == 9);
}

// Whether a text has a word; see keyed_formats.inc.
bool HasWord(const std::string& text, std::string word) {
  if (word[0] == '!') return !HasWord(text, word.substr(1));
  std::replace(word.begin(), word.end(), '~', ' ');
  if (word[0] != '^') return text.find(word) != std::string::npos;
  word.erase(0, 1);
  return text.rfind(word, 0) == 0 ||
         text.find("\n" + word) != std::string::npos;
}

// ---- Table -----------------------------------------------------------------

// Returns the enumerator of a word in a list in the order of the enumeration.
template <class Enum>
Enum FindEnumerator(const char* list, const std::string& word) {
  const std::vector<std::string> words = SplitText(list);
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end()) throw std::invalid_argument(word);
  return static_cast<Enum>(found - words.begin());
}

// Makes a model from the words of LENS.
ExternalModel MakeLens(const std::string& name,
                       const std::vector<std::string>& words) {
  const std::string& kind = words[0];
  if (kind == "omni")
    return MakeExternalModel(name, models::kOmniRadtan,
                             {"xi", "k1", "k2", "p1", "p2"});
  if (kind == "radial") return MakeRadialExternalModel(name);
  const bool is_pinhole = kind == "pinhole";
  if (is_pinhole && std::isdigit(static_cast<unsigned char>(words[1][0])))
    return MakeOpenCvModel(name, std::stoi(words[1]));
  ExternalModel model = MakeOpenCvFisheyeModel(name);
  if (kind == "fisheye" || kind == "form" || kind == "exact")
    model.max_supported_angle_rad = M_PI;
  if (words.size() == 1) return model;
  model.model = is_pinhole ? models::kOpenCv : words[1];
  const std::string list = words.back() == model.model ? "" : words.back();
  model.parameters = SplitText((kind == "exact"    ? ""
                                : kind == "single" ? "f,cx,cy,"
                                                   : "fx,fy,cx,cy,") +
                                   list,
                               ',');
  return model;
}

// Parses "NAME LENS [center|corner]: CONDITIONS -> VALUES".
KeyedModel ParseModel(const std::string& text,
                      const std::string& first_values) {
  const size_t colon = text.find(':'), arrow = text.find("->");
  std::vector<std::string> words = SplitText(text.substr(0, colon));
  const std::string name = words[0];
  words.erase(words.begin());
  PixelOrigin origin = PixelOrigin::kFirstPixelCenter;
  if (words.back() == "center" || words.back() == "corner") {
    origin = words.back() == "center" ? PixelOrigin::kImageCenter
                                      : PixelOrigin::kImageCorner;
    words.pop_back();
  }
  KeyedModel model;
  model.external_model = MakeLens(name, words);
  model.external_model.origin = origin;
  model.model_selector = text.substr(colon + 1, arrow - colon - 1);
  model.values = first_values + " " + text.substr(arrow + 2);
  return model;
}

// Parses "KIND [TOKEN] = KEYS".
KeyedPose ParsePose(const std::string& text) {
  const size_t equals = text.find(" = ");
  const std::vector<std::string> words = SplitText(text.substr(0, equals));
  return {text.substr(equals + 3),
          FindEnumerator<PoseKind>(
              "camera_from_rig rig_from_camera vectors baseline_mm "
              "rotation_translation inverse_rotation_translation",
              words[0]),
          words.size() > 1 ? words[1] : ""};
}

// Parses "NAME SYNTAX: DESCRIPTION".
KeyedFormat ParseHeading(const std::string& text) {
  const size_t colon = text.find(':');
  const std::vector<std::string> words = SplitText(text.substr(0, colon));
  KeyedFormat format;
  format.name = words[0];
  format.holds = text.substr(colon + 2);
  format.syntax = FindEnumerator<KeyedSyntax>(
      "yaml storage json toml lines assignments numbers blocks", words[1]);
  return format;
}

// Adds the entries of a line of keyed_formats.inc. first_values: those of
// "all".
void AddLine(const std::string& keyword, const std::string& rest,
             std::string* first_values, KeyedFormat* format) {
  static const std::map<std::string, std::string KeyedFormat::*> texts = {
      {"place", &KeyedFormat::place},      {"size", &KeyedFormat::size},
      {"name", &KeyedFormat::camera_name}, {"ones", &KeyedFormat::ones},
      {"ending", &KeyedFormat::ending},    {"fit", &KeyedFormat::fit_key}};
  static const std::map<std::string, std::vector<std::string> KeyedFormat::*>
      lists = {{"cameras", &KeyedFormat::words},
               {"others", &KeyedFormat::others},
               {"bulk", &KeyedFormat::bulk}};
  if (keyword == "all") {
    *first_values = rest;
  } else if (keyword == "text") {
    format->alternatives.push_back(SplitText(rest));
  } else if (keyword == "model" || keyword == "model-read-only") {
    format->models.push_back(ParseModel(rest, *first_values));
    format->models.back().is_read_only = keyword != "model";
  } else if (keyword == "pose") {
    format->poses.push_back(ParsePose(rest));
  } else if (keyword == "unit") {
    format->unit =
        FindEnumerator<LengthUnit>("pixel longer_side image_sides", rest);
  } else if (keyword == "write") {
    const std::vector<std::string> words = SplitText(rest);
    format->written.emplace_back(words[0], words[1]);
  } else if (const auto text = texts.find(keyword); text != texts.end()) {
    format->*text->second = rest;
  } else {
    std::vector<std::string>& list = format->*lists.at(keyword);
    list = SplitText(rest);
    std::replace(list.begin(), list.end(), std::string("-"), std::string());
  }
}

// The lines without comments, each with its continuations.
std::vector<std::string> JoinLines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const size_t first = line.find_first_not_of(' ');
    if (first == std::string::npos || line[first] == '#') continue;
    if (first >= 4)
      lines.back() += " " + line.substr(first);
    else
      lines.push_back(line.substr(first));
  }
  return lines;
}

std::vector<KeyedFormat> ParseFormats(const std::string& text) {
  std::vector<KeyedFormat> formats;
  std::string first_values;
  for (const std::string& line : JoinLines(text)) {
    const size_t space = std::min(line.find(' '), line.size());
    const std::string keyword = line.substr(0, space),
                      rest = line.substr(std::min(space + 1, line.size()));
    if (keyword == "format") {
      formats.push_back(ParseHeading(rest));
      first_values.clear();
    } else {
      AddLine(keyword, rest, &first_values, &formats.back());
    }
  }
  return formats;
}

}  // namespace

bool KeyedFormat::Recognizes(const std::string& text) const {
  if (syntax == KeyedSyntax::kNumbers) return IsNumberLine(text);
  if (syntax == KeyedSyntax::kBlocks) return IsInfiniTam(text);
  return std::any_of(
      alternatives.begin(), alternatives.end(), [&](const auto& all) {
        return std::all_of(
            all.begin(), all.end(),
            [&](const std::string& word) { return HasWord(text, word); });
      });
}

const std::vector<KeyedFormat>& ListKeyedFormats() {
  static const std::vector<KeyedFormat> table = ParseFormats(kFormats);
  return table;
}

std::vector<std::string> SplitText(const std::string& text, char space) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, space);)
    if (!word.empty()) words.push_back(word);
  return words;
}

std::string FindNumberLine(const std::string& text) {
  constexpr char kSpaces[] = " \t\r";
  std::istringstream lines(text);
  std::string found;
  for (std::string line; std::getline(lines, line);) {
    const size_t first = line.find_first_not_of(kSpaces);
    if (first == std::string::npos || line[first] == '#') continue;
    if (!found.empty()) return "another line";
    found = line;
  }
  return found;
}

std::string SubstituteCameraName(std::string key, const std::string& word) {
  for (const auto& [mark, text] :
       {std::pair('@', word), {'%', word.substr(0, 1)}})
    for (size_t at = key.find(mark); at != std::string::npos;
         at = key.find(mark, at + text.size()))
      key.replace(at, 1, text);
  return key;
}

KeyWithMark SplitAtMark(const std::string& text, char mark,
                        const std::string& word) {
  const size_t equals = text.find('=');
  KeyWithMark parted = {text.substr(0, equals), equals == std::string::npos
                                                    ? ""
                                                    : text.substr(equals + 1)};
  parted.has_mark = parted.key.back() == mark;
  if (parted.has_mark) parted.key.pop_back();
  parted.key = SubstituteCameraName(parted.key, word);
  return parted;
}

}  // namespace raygrid
