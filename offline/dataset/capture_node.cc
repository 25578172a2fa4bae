#include "dataset/capture_node.h"

#include <fmt/format.h>

#include <array>
#include <set>
#include <string>

#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

// Values that are stored, but not compared between files.
struct CaptureNumber {
  const char* key;
  std::optional<double> Capture::*value;
};
constexpr CaptureNumber kNumbers[] = {
    {"sensor_temperature_c", &Capture::sensor_temperature_c},
    {"exposure_us", &Capture::exposure_us},
    {"analogue_gain", &Capture::analogue_gain}};

// Rejects unknown keys: a misspelt key would silently disable the comparison.
void RequireCaptureKeys(const YAML::Node& node) {
  static const std::set<std::string> kKnown = {
      "lens_position", "lens_tolerance",       "crop",        "zoom",
      "orientation",   "sensor_temperature_c", "exposure_us", "analogue_gain"};
  if (!node.IsMap()) throw InputError("capture: not a mapping");
  for (const auto& entry : node)
    if (const auto key = entry.first.as<std::string>(); !kKnown.count(key))
      throw InputError(fmt::format("capture: unknown key '{}'; expected {}",
                                   Printable(key), fmt::join(kKnown, ", ")));
}

}  // namespace

std::optional<Capture> ParseCapture(const YAML::Node& node,
                                    const ImageSize& size) {
  if (!node) return std::nullopt;
  RequireCaptureKeys(node);
  Capture capture;
  if (node["lens_position"])
    capture.lens_position =
        YamlNumber(node["lens_position"], "capture: lens_position");
  if (node["lens_tolerance"]) {
    if (!capture.lens_position)
      throw InputError("capture: lens_tolerance requires lens_position");
    capture.lens_tolerance =
        YamlNumber(node["lens_tolerance"], "capture: lens_tolerance");
  }
  if (node["crop"]) {
    RequireYamlList(node["crop"], "capture: crop", 4);
    capture.crop = node["crop"].as<std::array<int, 4>>();
  }
  if (node["zoom"]) capture.zoom = YamlNumber(node["zoom"], "capture: zoom");
  if (node["orientation"]) capture.orientation = node["orientation"].as<int>();
  for (const CaptureNumber& number : kNumbers)
    if (node[number.key])
      capture.*number.value =
          YamlNumber(node[number.key], std::string("capture: ") + number.key);
  if (!capture.HasAny()) throw InputError("capture: empty");
  if (const char* const impossible = FindInvalidValue(capture, size))
    throw InputError(std::string("capture: ") + impossible);
  return capture;
}

void EmitCapture(const Capture& capture, YAML::Emitter* out) {
  *out << YAML::Key << "capture" << YAML::Value << YAML::BeginMap;
  if (capture.lens_position)
    *out << YAML::Key << "lens_position" << YAML::Value
         << fmt::format("{}", *capture.lens_position) << YAML::Key
         << "lens_tolerance" << YAML::Value
         << fmt::format("{}", capture.lens_tolerance);
  if (capture.crop) {
    *out << YAML::Key << "crop" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const int number : *capture.crop) *out << number;
    *out << YAML::EndSeq;
  }
  if (capture.zoom)
    *out << YAML::Key << "zoom" << YAML::Value
         << fmt::format("{}", *capture.zoom);
  if (capture.orientation)
    *out << YAML::Key << "orientation" << YAML::Value << *capture.orientation;
  for (const CaptureNumber& number : kNumbers)
    if (const auto& value = capture.*number.value)
      *out << YAML::Key << number.key << YAML::Value
           << fmt::format("{}", *value);
  *out << YAML::EndMap;
}

}  // namespace raygrid
