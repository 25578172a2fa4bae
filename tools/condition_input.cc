#include "condition_input.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <set>
#include <utility>

#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/exif_condition.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "named_camera.h"
#include "session_file.h"

namespace raygrid {
namespace {

struct FolderAt {
  std::string text;  // the value as it was given
  double value = 0;
  std::string folder;
};

std::vector<FolderAt> ParseFolders(const std::vector<std::string>& texts) {
  std::vector<FolderAt> folders;
  for (const std::string& text : texts) {
    const NamedValue given = ParseNamedValue(text);
    char* end;
    const double value = std::strtod(given.name.c_str(), &end);
    if (given.name.empty() || *end != 0 || !std::isfinite(value) ||
        given.value.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("--camera-at {}: expected VALUE=FOLDER, as "
                              "2.5=photos/near",
                              text));
    folders.push_back({given.name, value, given.value});
    // A session of capture has its frames in a folder of its own.
    if (IsSession(given.value))
      folders.back().folder += std::string("/") + kSessionFrames;
  }
  return folders;
}

void ReadValues(const std::string& path,
                std::map<std::string, double>* values) {
  const CsvTable table(path, ReadFile(path), {"image", "value"});
  for (size_t i = 0; i < table.num_rows(); ++i)
    if (!values->emplace(table.Text(i, "image"), table.Number(i, "value"))
             .second)
      throw InputError(fmt::format("{}: {} has a value already", table.Place(i),
                                   table.Text(i, "image")));
}

CameraCondition ConditionOf(const CalibrateArguments& arguments) {
  return arguments.condition == ConditionName(CameraCondition::kTemperature)
             ? CameraCondition::kTemperature
             : CameraCondition::kLensPosition;
}

// The values that images have in their EXIF data, by path. Files that are no
// images have none, and are named by who measures them.
std::map<std::string, double> ReadExifValues(
    const std::vector<std::string>& paths, CameraCondition condition) {
  std::map<std::string, double> values;
  for (const std::string& path : paths) {
    std::optional<double> value;
    try {
      value = ExifCondition(path, ReadImageFile(path), condition);
    } catch (const InputError&) {
      continue;
    }
    if (!value)
      throw InputError(fmt::format(
          "{}: its EXIF data do not tell the {} ({}); give --camera-at "
          "VALUE=FOLDER for each value, or --conditions FILE.csv",
          path, ConditionName(condition), ExifTagName(condition)));
    values[path] = *value;
  }
  return values;
}

}  // namespace

void AddConditionOptions(CLI::App* command, CalibrateArguments* arguments) {
  command
      ->add_option("--condition", arguments->condition,
                   "calibrate over a range of it, the camera being a function "
                   "of it: lens_position (dioptres) or temperature (°C of the "
                   "sensor). The values are those of a session's frames, of "
                   "--camera-at, of --conditions, or else those that images "
                   "have in their EXIF data: SubjectDistance, of which 1 / "
                   "metres is taken, or AmbientTemperature")
      ->check(CLI::IsMember({"lens_position", "temperature"}));
  command
      ->add_option("--camera-at", arguments->cameras_at,
                   "VALUE=FOLDER, once for each lens position or temperature "
                   "that images were taken at, instead of images")
      ->type_name("VALUE=FOLDER")
      ->allow_extra_args(false);
  command
      ->add_option("--conditions", arguments->conditions,
                   "CSV with the columns image, value: the lens position or "
                   "temperature in each image")
      ->type_name("FILE");
}

void RequireConditionOptions(const CalibrateArguments& arguments, bool is_rig) {
  const bool has_values =
      !arguments.cameras_at.empty() || !arguments.conditions.empty();
  if (arguments.condition.empty() && has_values)
    throw Error(ExitCode::kUsage,
                "say what the values of --camera-at or --conditions are: "
                "--condition lens_position or --condition temperature");
  if (arguments.condition.empty()) return;
  if (is_rig)
    throw Error(ExitCode::kUsage,
                "--condition is for a single camera; calibrate a rig's cameras "
                "one by one");
  if (!arguments.cameras_at.empty() && !arguments.conditions.empty())
    throw Error(ExitCode::kUsage,
                "give either --camera-at or --conditions, not both");
  if (!has_values && arguments.session_values.empty() && !AreOfExif(arguments))
    throw Error(ExitCode::kUsage,
                fmt::format("--condition {}: nothing says it of the images; "
                            "give --camera-at VALUE=FOLDER for each value, or "
                            "--conditions FILE.csv",
                            arguments.condition));
}

bool AreOfExif(const CalibrateArguments& arguments) {
  return !arguments.condition.empty() && !arguments.images.empty() &&
         arguments.captures.empty() && arguments.cameras_at.empty() &&
         arguments.conditions.empty();
}

Measurements MeasureWithExif(const std::vector<std::string>& images,
                             const CalibrateArguments& arguments,
                             const CommonOptions& common,
                             const Pattern& pattern,
                             const std::function<void(double)>& progress) {
  const std::map<std::string, double> values =
      ReadExifValues(FindImages(images).paths, ConditionOf(arguments));
  Measurements measurements =
      Measure(images, pattern, arguments.pattern, common, progress);
  for (size_t i = 0; i < measurements.paths.size(); ++i)
    if (const auto value = values.find(measurements.paths[i]);
        value != values.end())
      measurements.condition_values[measurements.dataset.images[i].image] =
          value->second;
  return measurements;
}

Measurements MeasureFoldersAt(const CalibrateArguments& arguments,
                              const CommonOptions& common,
                              const Pattern& pattern,
                              const std::function<void(double)>& progress) {
  const std::vector<FolderAt> folders = ParseFolders(arguments.cameras_at);
  std::set<std::string> values;
  for (const FolderAt& folder : folders)
    if (!values.insert(folder.text).second)
      throw Error(
          ExitCode::kUsage,
          fmt::format("--camera-at {}={}: the value is given twice; put "
                      "its images into one folder",
                      folder.text, folder.folder));
  Measurements measurements;
  for (size_t k = 0; k < folders.size(); ++k) {
    const auto part = [&](double done) {
      progress((static_cast<double>(k) + done) /
               static_cast<double>(folders.size()));
    };
    Measurements more =
        Measure({folders[k].folder}, pattern, arguments.pattern, common, part);
    for (ImageFeatures& image : more.dataset.images) {
      image.image = folders[k].text + "/" + image.image;
      more.condition_values[image.image] = folders[k].value;
    }
    if (k > 0 && more.dataset.image_size != measurements.dataset.image_size)
      throw InputError(
          fmt::format("{}: images of {} x {} pixels, but those of "
                      "{} are {} x {}",
                      folders[k].folder, more.dataset.image_size.width,
                      more.dataset.image_size.height, folders[0].folder,
                      measurements.dataset.image_size.width,
                      measurements.dataset.image_size.height));
    Append(std::move(more), &measurements);
  }
  return measurements;
}

std::optional<double> ValueOf(const CalibrateArguments& arguments,
                              const SessionFrame& frame) {
  if (arguments.condition.empty()) return std::nullopt;
  return ConditionOf(arguments) == CameraCondition::kLensPosition
             ? frame.lens_position
             : frame.sensor_temperature_c;
}

std::optional<ImageConditions> ConditionsOf(const CalibrateArguments& arguments,
                                            const Measurements& measurements) {
  if (arguments.condition.empty()) return std::nullopt;
  ImageConditions conditions;
  conditions.condition = ConditionOf(arguments);
  conditions.values = measurements.condition_values;
  if (!arguments.conditions.empty())
    ReadValues(arguments.conditions, &conditions.values);
  else if (conditions.values.empty())
    conditions.values = arguments.session_values;
  return conditions;
}

}  // namespace raygrid
