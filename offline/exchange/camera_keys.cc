#include "exchange/camera_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/keyed_table.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

bool IsIn(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

// Reduces keys to lower-case letters and digits, because programs differ in
// other characters.
std::string NormalizeKey(const std::string& text) {
  std::string plain;
  for (const char c : Lowercase(text))
    if (std::isalnum(static_cast<unsigned char>(c))) plain += c;
  return plain;
}

// Whether a key selects the camera model in some format.
bool IsSelector(const std::string& plain) {
  static const std::vector<std::string> selectors = SplitText(
      "cameramodel cameratype lensmodel lenstype distortionmodel "
      "distortiontype distmodel modeltype projection projectiontype "
      "projectionmodel isfisheye fisheye fisheyemodel usefisheye "
      "useopencvfisheye omnidirectional isomnidirectional model cammodel "
      "imgdisttype undistortiontype");
  return IsIn(selectors, plain);
}

// Whether a key is a camera model parameter in some format.
bool IsParameter(const std::string& plain) {
  static const std::vector<std::string> parameters = SplitText(
      "xi alpha beta skew omega mirrorparameters alphac alphacleft "
      "alphacright affine poly polynomial invpoly b1 b2 k1 k2 k3 k4 k5 k6 p1 "
      "p2 p3 p4 s1 s2 s3 s4 sx1 sy1 taux tauy corrections digitallens "
      "undistortionparams undistortionoffset");
  return IsIn(parameters, plain);
}

// Whether a value is null, 0, or a list or matrix of zeros.
bool HasNoValue(const YAML::Node& value, int depth = 0) {
  constexpr int kDeepest = 2;
  if (!value.IsDefined() || value.IsNull()) return true;
  if (depth > kDeepest) return false;
  if (value.IsScalar()) {
    const std::string text = Lowercase(value.as<std::string>());
    double number = 1;
    return text.empty() || text == "false" || text == "none" ||
           text == "null" || text == "no" ||
           (YAML::convert<double>::decode(value, number) && number == 0);
  }
  return std::all_of(value.begin(), value.end(), [&](const auto& entry) {
    return HasNoValue(value.IsMap() ? entry.second : YAML::Node(entry),
                      depth + 1);
  });
}

// Returns the last component of a key path: k1 of "Camera.k1".
std::string GetLastKey(const std::string& path) {
  return path.substr(path.find_last_of("/.") + 1);
}

ModelFamily GetModelFamily(const ExternalModel& external_model) {
  if (external_model.model == models::kThinPrismFisheye)
    return ModelFamily::kFisheye;
  if (external_model.model == models::kOpenCv ||
      external_model.model == models::kOpenCv14)
    return ModelFamily::kPinhole;
  return external_model.model == models::kOmniRadtan ? ModelFamily::kOmni
                                                     : ModelFamily::kOther;
}

// Whether a model selector is consistent with the external model. Kalibr also
// uses "pinhole" for fisheye cameras and states the distortion separately.
bool HasConsistentSize(const std::string& key, const YAML::Node& value,
                       const ExternalModel& external_model) {
  if (HasNoValue(value) || !value.IsScalar()) return true;
  const std::string text = NormalizeKey(value.as<std::string>());
  const ModelFamily own = GetModelFamily(external_model);
  if (text == "true" || text == "1" || text == "yes") {
    const auto names = [&](const char* word) {
      return key.find(word) != std::string::npos;
    };
    return !(names("fisheye") && own != ModelFamily::kFisheye) &&
           !(names("omni") && own != ModelFamily::kOmni);
  }
  const auto family = ParseModelFamily(text);
  // Unknown values of other keys are vendor names.
  if (!family)
    return key.find("distortion") == std::string::npos && key != "projection";
  return (*family == own && own != ModelFamily::kOther) || text == "pinhole";
}

// Whether a value duplicates a parameter's value.
bool IsValueOfModel(const ExternalModel& external_model,
                    const std::vector<double>& values,
                    const std::string& parameter, const YAML::Node& value) {
  double number = NAN;
  if (!value.IsScalar() || !YAML::convert<double>::decode(value, number))
    return false;
  for (size_t k = 0;
       k < std::min(values.size(), external_model.parameters.size()); ++k)
    if (external_model.parameters[k] == parameter)
      return std::abs(values[k] - number) <= 1e-6 * std::abs(values[k]);
  return false;
}

}  // namespace

// Compares whole words, because vendor names such as OmniVision and oCam
// contain names of models.
std::optional<ModelFamily> ParseModelFamily(const std::string& word) {
  static const std::map<ModelFamily, std::vector<std::string>> families = {
      {ModelFamily::kPinhole,
       SplitText(
           "pinhole plumbbob rational rationalpolynomial perspective radtan "
           "radialtangential brownconrady rectilinear opencv opencvstandard "
           "standard radial simpleradial simplepinhole fullopencv "
           "pinholeradtan")},
      {ModelFamily::kFisheye,
       SplitText(
           "fisheye opencvfisheye fisheyeopencv equidistant equi "
           "equidistantfisheye kannalabrandt kannalabrandt4 kannalabrandt8 "
           "kb kb4 kb8 pinholeequi pinholeequidistant")},
      {ModelFamily::kOmni,
       SplitText("omni omnidir omnidirectional omniradtan mei catadioptric")},
      {ModelFamily::kOther,
       SplitText(
           "inversebrownconrady modifiedbrownconrady scaramuzza ocam "
           "ocamcalib eucm doublesphere ds ucm fov atan equirectangular "
           "spherical stereographic equisolid equisolidangle orthographic "
           "ftheta division radialdivision cahvor cahvore thinprismfisheye "
           "fisheye62 fisheye624 radtanthinprismfisheye cylindrical")}};
  std::string plain = NormalizeKey(word);
  for (const char* before : {"distortion", "cv"})
    if (plain.rfind(before, 0) == 0) plain.erase(0, std::strlen(before));
  for (const char* behind : {"model", "camera", "lens"})
    if (const size_t at = plain.rfind(behind);
        at != std::string::npos && at > 0 &&
        at + std::strlen(behind) == plain.size())
      plain.resize(at);
  for (const auto& [family, words] : families)
    if (IsIn(words, plain)) return family;
  return std::nullopt;
}

const char* ToString(ModelFamily family) {
  switch (family) {
    case ModelFamily::kPinhole:
      return "a pinhole";
    case ModelFamily::kFisheye:
      return "a fisheye";
    case ModelFamily::kOmni:
      return "an omnidirectional camera";
    default:
      return "another camera model";
  }
}

CameraKeys::CameraKeys(const YAML::Node& map, std::string name)
    : map_(map), name_(std::move(name)) {
  if (!map_.IsDefined() || !map_.IsMap())
    throw InputError((name_.empty() ? "not a camera" : name_) +
                     ": expected a mapping");
}

YAML::Node CameraKeys::operator[](const std::string& path) const {
  read_.insert(path);
  return Find(path);
}

bool CameraKeys::Has(const std::string& path) const {
  return Find(path).IsDefined();
}

bool CameraKeys::IsMatrix(const std::string& path) const {
  const YAML::Node node = Find(path);
  if (!node.IsDefined()) return false;
  if (node.IsSequence()) return node.size() == 0 || !node[0].IsMap();
  return !node.IsMap() || YAML::Node(node)["data"].IsDefined();
}

bool CameraKeys::IsEmptyText(const std::string& path) const {
  const YAML::Node node = Find(path);
  return node.IsDefined() && node.IsScalar() && node.Scalar().empty();
}

std::string CameraKeys::Word(const std::string& path) const {
  const YAML::Node node = Find(path);
  return node.IsDefined() && node.IsScalar() ? node.as<std::string>() : "";
}

bool CameraKeys::HasKeyWith(const std::vector<std::string>& parts) const {
  return std::any_of(map_.begin(), map_.end(), [&](const auto& entry) {
    return entry.first.IsScalar() &&
           std::any_of(parts.begin(), parts.end(), [&](const auto& part) {
             return Lowercase(entry.first.template as<std::string>())
                        .find(part) != std::string::npos;
           });
  });
}

YAML::Node CameraKeys::Find(const std::string& path) const {
  YAML::Node node = map_;
  for (size_t at = 0; at <= path.size();) {
    const size_t end = std::min(path.find('/', at), path.size());
    if (!node.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    const YAML::Node map = node;
    const YAML::Node value = map[path.substr(at, end - at)];
    if (!value.IsDefined()) return YAML::Node(YAML::NodeType::Undefined);
    node.reset(value);
    at = end + 1;
  }
  return node;
}

void CameraKeys::NameOnly(const std::vector<std::string>& keys) const {
  named_only_.insert(keys.begin(), keys.end());
}

void CameraKeys::Skip(const std::vector<std::string>& keys) const {
  for (const std::string& key : keys) {
    if (key.back() == '*')
      skipped_prefixes_.push_back(key.substr(0, key.size() - 1));
    else
      read_.insert(key);
  }
}

void CameraKeys::CollectUnread(
    const YAML::Node& map, const std::string& prefix,
    std::vector<std::pair<std::string, YAML::Node>>* unread) const {
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) continue;
    const std::string path = prefix + entry.first.as<std::string>();
    if (read_.count(path) > 0) continue;
    if (std::any_of(skipped_prefixes_.begin(), skipped_prefixes_.end(),
                    [&](const std::string& begin) {
                      return path.rfind(begin, 0) == 0;
                    }))
      continue;
    const auto below = read_.lower_bound(path + "/");
    if (entry.second.IsMap() && below != read_.end() &&
        below->rfind(path + "/", 0) == 0)
      CollectUnread(entry.second, path + "/", unread);
    else
      unread->emplace_back(path, entry.second);
  }
}

void CameraKeys::Finish(const ExternalModel& external_model,
                        std::vector<std::string>* warnings,
                        const std::vector<double>& values) const {
  std::vector<std::pair<std::string, YAML::Node>> unread;
  CollectUnread(map_, "", &unread);
  const std::string of_camera = name_.empty() ? "" : name_ + ": ";
  constexpr size_t kMaxNames = 12;
  std::string names;
  size_t count = 0;
  for (const auto& [path, value] : unread) {
    const std::string plain = NormalizeKey(GetLastKey(path));
    if (IsValueOfModel(external_model, values, plain, value)) continue;
    const bool is_only_named = named_only_.count(path) > 0;
    const bool is_selector = IsSelector(plain) && !is_only_named,
               is_parameter = IsParameter(plain) && !is_only_named,
               is_nothing = HasNoValue(value);
    if (is_selector ? !HasConsistentSize(plain, value, external_model)
                    : is_parameter && !is_nothing)
      throw InputError(fmt::format(
          "{}'{}'{} contradicts {}, the camera model implied by the other "
          "keys; remove it if it is not an intrinsic parameter",
          of_camera, Printable(path),
          value.IsScalar()
              ? fmt::format(", '{}',", Printable(value.as<std::string>()))
              : "",
          external_model.name));
    if (is_nothing && (is_selector || is_parameter || value.IsNull())) continue;
    if (++count <= kMaxNames)
      names += (names.empty() ? "" : ", ") + Printable(path);
  }
  if (count > kMaxNames)
    names += fmt::format(" and {} more", count - kMaxNames);
  if (count > 0)
    warnings->push_back(of_camera + "unknown keys ignored: " + names);
}

}  // namespace raygrid
