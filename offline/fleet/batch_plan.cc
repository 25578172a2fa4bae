#include "fleet/batch_plan.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <tuple>

#include "camera/operating_point_model.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

constexpr size_t kMaxSerialSize = 31;  // the limit of blobs
constexpr char kVaryWith[] = "vary_with";
constexpr char kImagesAt[] = "images_at";
constexpr char kOperatingPoints[] = "operating_points";
constexpr char kTimestamps[] = "timestamps";
constexpr char kPrior[] = "prior";

// Keys of a plan or a unit, and the corresponding options of raygrid calibrate:
// options with a value, followed by flags.
const std::vector<std::pair<std::string, std::string>> kValueOptions = {
    {"model", "--model"},
    {"knot_spacing_px", "--knot-spacing-px"},
    {"image_size", "--image-size"},
    {"area", "--area"},
    {kVaryWith, "--vary-with"},
    {"duplicate_px", "--duplicate-px"},
    {"valid_px", "--valid-px"},
    {"image_circle", "--image-circle"},
    {"seed", "--seed"},
    {"name", "--name"}};
const std::vector<std::pair<std::string, std::string>> kFlagOptions = {
    {"fix_target_geometry", "--fix-target-geometry"},
    {"rigid_target", "--rigid-target"},
    {"no_refine_features", "--no-refine-features"},
    {"rolling_shutter", "--rolling-shutter"},
    {"skip_comparison", "--skip-comparison"}};
// The options whose value is a file.
const std::vector<std::string> kFileOptions = {kOperatingPoints, kPrior,
                                               kTimestamps};
// Former names of keys, which remain valid for one minor version.
const std::map<std::string, std::string> kDeprecatedKeys = {
    {"cell_px", "knot_spacing_px"},
    {"condition", kVaryWith},
    {"conditions", kOperatingPoints},
    {"cameras_at", kImagesAt},
    {"same_view_px", "duplicate_px"},
    {"flat_board", "fix_target_geometry"},
    {"rigid_board", "rigid_target"},
    {"measure_once", "no_refine_features"},
    {"like", kPrior},
    {"times", kTimestamps}};
// Former names of limits, also valid for one minor version.
const std::map<std::string, std::string> kDeprecatedMetrics = {
    {"trusted_part", "valid_fraction"},
    {"valid_share", "valid_fraction"},
    {"worst_deviation_px", "max_uncertainty_px"}};

// Replaces former keys of a plan or unit by the current ones.
YAML::Node ReplaceDeprecatedKeys(const YAML::Node& map,
                                 const std::string& what) {
  std::map<std::string, YAML::Node> values;
  bool has_former = false;
  for (const auto& entry : map) {
    const std::string key = entry.first.as<std::string>();
    const auto former = kDeprecatedKeys.find(key);
    has_former |= former != kDeprecatedKeys.end();
    const std::string& name =
        former == kDeprecatedKeys.end() ? key : former->second;
    if (!values.emplace(name, entry.second).second)
      throw InputError(fmt::format(
          "{}: duplicate key '{}' (its former name counts as the same key)",
          what, Printable(name)));
  }
  // Maps without former keys are not copied: each assignment below visits all
  // nodes of the document, so that the time for reading a plan would grow
  // quadratically with the number of units.
  if (!has_former) return map;
  YAML::Node current(YAML::NodeType::Map);
  for (const auto& [name, value] : values) current[name] = value;
  return current;
}

void RequireKnownKeys(const YAML::Node& map, const std::string& what,
                      const std::set<std::string>& own_keys) {
  std::set<std::string> known = own_keys;
  for (const auto* options : {&kValueOptions, &kFlagOptions})
    for (const auto& option : *options) known.insert(option.first);
  known.insert(kFileOptions.begin(), kFileOptions.end());
  for (const auto& entry : map) {
    const std::string key = entry.first.as<std::string>();
    if (known.count(key) == 0)
      throw InputError(fmt::format("{}: unknown key '{}'; expected {}", what,
                                   Printable(key), fmt::join(known, ", ")));
  }
}

// Formats a condition, or a comma-separated list of several, as the value of
// --vary-with.
std::string FormatOperatingPoint(const YAML::Node& value) {
  const std::vector<YAML::Node> several =
      value.IsSequence() ? std::vector<YAML::Node>(value.begin(), value.end())
                         : std::vector<YAML::Node>{value};
  std::vector<std::string> names;
  for (const YAML::Node& node : several) {
    const std::string name = node.IsScalar() ? node.Scalar() : "";
    if (!FindOperatingParameter(name))
      throw InputError(fmt::format(
          "vary_with: unknown quantity '{}'; expected lens_position, "
          "temperature or [lens_position, temperature]",
          Printable(name)));
    names.push_back(name);
  }
  return fmt::format("{}", fmt::join(names, ","));
}

// Formats a number, a string, or [width, height], as the value of an option.
std::string FormatOption(const YAML::Node& value, const std::string& key) {
  if (value.IsSequence() && key == "image_size") {
    RequireYamlList(value, "image_size", 2);
    return fmt::format("{}x{}", value[0].as<int>(), value[1].as<int>());
  }
  if (key == kVaryWith) return FormatOperatingPoint(value);
  if (!value.IsScalar())
    throw InputError(fmt::format("key '{}': expected a single value", key));
  return value.as<std::string>();
}

bool IsTrue(const YAML::Node& value, const std::string& key) {
  bool is_true = false;
  if (!value.IsScalar() || !YAML::convert<bool>::decode(value, is_true))
    throw InputError(fmt::format("line {}: key '{}': expected true or false",
                                 value.Mark().line + 1, key));
  return is_true;
}

// Returns the unit's value of a key, otherwise the plan's.
YAML::Node Find(const YAML::Node& unit, const YAML::Node& plan,
                const std::string& key) {
  return unit[key] ? unit[key] : plan[key];
}

std::vector<std::string> ReadOptions(const YAML::Node& unit,
                                     const YAML::Node& plan) {
  std::vector<std::string> options;
  for (const auto& [key, option] : kValueOptions)
    if (const YAML::Node value = Find(unit, plan, key))
      options.push_back(option + "=" + FormatOption(value, key));
  for (const auto& [key, option] : kFlagOptions)
    if (const YAML::Node value = Find(unit, plan, key);
        value && IsTrue(value, key))
      options.push_back(option);
  return options;
}

std::map<std::string, std::string> ReadFolders(const YAML::Node& node,
                                               const std::string& key) {
  std::map<std::string, std::string> folders;
  if (!node) return folders;
  if (!node.IsMap())
    throw InputError(
        fmt::format("key '{}': expected a mapping of folders", key));
  for (const auto& entry : node)
    folders[entry.first.as<std::string>()] = entry.second.as<std::string>();
  return folders;
}

bool IsNumber(const std::string& text) {
  char* end;
  return std::isfinite(std::strtod(text.c_str(), &end)) && !text.empty() &&
         *end == 0;
}

// Throws for combinations of options that calibrate would reject for every
// unit.
void RequireOptionsFit(const BatchUnit& unit, const YAML::Node& node,
                       const YAML::Node& plan) {
  const bool has_variation = Find(node, plan, kVaryWith).IsDefined();
  const YAML::Node shutter = Find(node, plan, "rolling_shutter");
  const bool has_shutter = shutter && IsTrue(shutter, "rolling_shutter");
  const auto& files = unit.option_files;
  if (!has_variation &&
      (files.count(kOperatingPoints) || !unit.cameras_at.empty()))
    throw InputError(fmt::format(
        "unit {}: {} requires vary_with: lens_position or vary_with: "
        "temperature",
        unit.serial, unit.cameras_at.empty() ? kOperatingPoints : kImagesAt));
  if (has_shutter && has_variation)
    throw InputError(fmt::format(
        "unit {}: rolling_shutter and vary_with cannot be combined; "
        "remove one of them",
        unit.serial));
  if (has_variation && !unit.features.empty() && !files.count(kOperatingPoints))
    throw InputError(
        fmt::format("unit {}: vary_with requires the operating point of each "
                    "image in features; specify operating_points: FILE.csv",
                    unit.serial));
  for (const auto& [value, folder] : unit.cameras_at)
    if (!IsNumber(value))
      throw InputError(fmt::format("unit {}: images_at: '{}' is not a number",
                                   unit.serial, Printable(value)));
  if (!unit.cameras_at.empty() &&
      FormatOperatingPoint(Find(node, plan, kVaryWith)).find(',') !=
          std::string::npos)
    throw InputError(
        fmt::format("unit {}: images_at takes values of one quantity; for both "
                    "specify operating_points: FILE.csv",
                    unit.serial));
  if (has_shutter && !unit.features.empty() && !files.count(kTimestamps))
    throw InputError(
        fmt::format("unit {}: rolling_shutter requires the timestamp of each "
                    "image in features; specify timestamps: FILE.csv",
                    unit.serial));
  if (!has_shutter && files.count(kTimestamps))
    throw InputError(fmt::format(
        "unit {}: timestamps requires rolling_shutter: true", unit.serial));
}

void RequireSerial(const std::string& serial) {
  const std::string kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-+";
  if (serial.empty() || serial.size() > kMaxSerialSize ||
      serial.find_first_not_of(kLetters) != std::string::npos ||
      serial[0] == '.' || serial[0] == '-')
    throw InputError(
        fmt::format("serial '{}': must have 1 to {} letters, digits or . _ - "
                    "+, and not begin with . or -",
                    Printable(serial), kMaxSerialSize));
  if (serial == "fleet.csv" || serial == "fleet.html" ||
      serial == "fleet_camera.yaml" ||
      serial.find(".failed") != std::string::npos)
    throw InputError(
        fmt::format("serial '{}': reserved for a file of the batch", serial));
}

// Returns the scalar value of a key; empty if the key is missing.
std::string ReadText(const YAML::Node& map, const std::string& key) {
  return map[key] ? FormatOption(map[key], key) : std::string();
}

BatchUnit ReadUnit(const YAML::Node& given, const YAML::Node& plan) {
  if (!given.IsMap() || !given["serial"])
    throw InputError("units: missing serial");
  BatchUnit unit;
  unit.serial = ReadText(given, "serial");
  RequireSerial(unit.serial);
  const std::string what = "unit " + unit.serial;
  const YAML::Node node = ReplaceDeprecatedKeys(given, what);
  RequireKnownKeys(node, what,
                   {"serial", "images", "features", "cameras", kImagesAt,
                    "pattern", "lens_batch", "repeats", "operator", "station"});
  unit.pattern = ReadText(node["pattern"] ? node : plan, "pattern");
  unit.images = ReadText(node, "images");
  unit.features = ReadText(node, "features");
  unit.cameras = ReadFolders(node["cameras"], "cameras");
  unit.cameras_at = ReadFolders(node[kImagesAt], kImagesAt);
  if (!unit.images.empty() + !unit.features.empty() + !unit.cameras.empty() +
          !unit.cameras_at.empty() !=
      1)
    throw InputError(
        what +
        ": requires exactly one of images (folder), features (file), cameras "
        "(folders by camera) and images_at (folders by value of vary_with)");
  if (unit.pattern.empty())
    throw InputError(what + ": missing pattern, in the unit or the plan");
  unit.options = ReadOptions(node, plan);
  for (const std::string& key : kFileOptions)
    if (const YAML::Node value = Find(node, plan, key))
      unit.option_files[key] = FormatOption(value, key);
  RequireOptionsFit(unit, node, plan);
  unit.lens_batch = ReadText(node, "lens_batch");
  unit.repeats = ReadText(node, "repeats");
  if (!unit.repeats.empty()) RequireSerial(unit.repeats);
  unit.person = ReadText(node, "operator");
  unit.station = ReadText(node, "station");
  return unit;
}

MetricLimits ReadLimits(const YAML::Node& node) {
  MetricLimits limits;
  const std::vector<std::string>& names = ListMetricNames();
  for (const auto& entry : node) {
    std::string name = entry.first.as<std::string>();
    if (const auto former = kDeprecatedMetrics.find(name);
        former != kDeprecatedMetrics.end())
      name = former->second;
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InputError(fmt::format("limits: unknown '{}'; expected {}",
                                   Printable(name), fmt::join(names, ", ")));
    if (entry.second.IsSequence()) {
      RequireYamlList(entry.second, name.c_str(), 2);
      limits[name] = {YamlNumber(entry.second[0], name),
                      YamlNumber(entry.second[1], name)};
    } else {
      limits[name] = {-std::numeric_limits<double>::infinity(),
                      YamlNumber(entry.second, name)};
    }
    if (limits[name].first > limits[name].second)
      throw InputError(
          fmt::format("limits: {}: the lower limit must come first", name));
  }
  return limits;
}

// Checks that each repeat refers to a unit, and that the operator is specified
// for all calibrations of golden units or for none, and so is the station.
void RequireRepeatsFit(const std::vector<BatchUnit>& units) {
  std::set<std::string> goldens, repeats;
  for (const BatchUnit& unit : units)
    if (!unit.repeats.empty()) {
      goldens.insert(unit.repeats);
      repeats.insert(unit.serial);
    }
  std::set<std::string> serials;
  for (const BatchUnit& unit : units) serials.insert(unit.serial);
  for (const BatchUnit& unit : units)
    if (!unit.repeats.empty() && serials.count(unit.repeats) == 0)
      throw InputError(
          fmt::format("unit {}: repeats {}, which is not in the plan",
                      unit.serial, unit.repeats));
  const BatchUnit* first = nullptr;
  for (const BatchUnit& unit : units) {
    const bool is_golden = goldens.count(unit.serial) > 0;
    if (repeats.count(unit.serial) > 0 && is_golden)
      throw InputError(
          fmt::format("unit {0}: a golden unit cannot itself repeat another "
                      "unit, {1}; let all repetitions refer to {1}",
                      unit.serial, unit.repeats));
    if (!is_golden && unit.repeats.empty()) continue;
    if (!first) first = &unit;
    for (const auto& [key, text, of_first] :
         {std::tuple("operator", &unit.person, &first->person),
          std::tuple("station", &unit.station, &first->station)})
      if (text->empty() != of_first->empty())
        throw InputError(
            fmt::format("unit {}: of the golden units {} and {}, one has no "
                        "{}; specify it for all of them or for none",
                        unit.serial, first->serial, unit.serial, key));
  }
}

BatchPlan ReadPlan(const YAML::Node& given) {
  RequireKind(given, "batch");
  const YAML::Node root = ReplaceDeprecatedKeys(given, "plan");
  if (root["raygrid_batch"].as<int>() != 1)
    throw InputError("raygrid_batch: only version 1 is supported");
  RequireKnownKeys(root, "plan",
                   {"raygrid_batch", "pattern", "limits", "units"});
  BatchPlan plan;
  if (root["limits"]) plan.limits = ReadLimits(root["limits"]);
  if (!root["units"] || !root["units"].IsSequence() ||
      root["units"].size() == 0)
    throw InputError("units: expected a list");
  for (const YAML::Node& node : root["units"])
    plan.units.push_back(ReadUnit(node, root));
  std::sort(plan.units.begin(), plan.units.end(),
            [](const BatchUnit& a, const BatchUnit& b) {
              return a.serial < b.serial;
            });
  for (size_t k = 1; k < plan.units.size(); ++k)
    if (plan.units[k].serial == plan.units[k - 1].serial)
      throw InputError(
          fmt::format("duplicate serial '{}'", plan.units[k].serial));
  RequireRepeatsFit(plan.units);
  return plan;
}

}  // namespace

const std::vector<std::string>& ListMetricNames() {
  static const std::vector<std::string> kNames = {
      "center_x_px",        "center_y_px",     "focal_px", "held_out_max_px",
      "held_out_median_px", "held_out_rms_px", "images",   "max_uncertainty_px",
      "training_median_px", "valid_fraction"};
  return kNames;
}

BatchPlan ParseBatchPlan(const std::string& path, const std::string& text) {
  return ReadNamingFile(path, [&] {
    RequireYamlFile(path, text);
    return ReadPlan(YAML::Load(text));
  });
}

}  // namespace raygrid
