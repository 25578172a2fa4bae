#include "operating_point_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <tuple>
#include <utility>

#include "camera_values.h"
#include "dataset/csv.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/exif_operating_point.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/image_header.h"
#include "dataset/text_encoding.h"
#include "session_file.h"

namespace raygrid {
namespace {

struct FolderAt {
  std::string text;  // the value as the user wrote it
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
      throw Error(
          ExitCode::kUsage,
          fmt::format(
              "--images-at {}: expected VALUE=FOLDER, such as 2.5=photos/near",
              text));
    folders.push_back({given.name, value, given.value});
    // The frames of a capture session are in a subfolder.
    if (IsSession(given.value))
      folders.back().folder += std::string("/") + kSessionFrames;
  }
  // The result must not depend on the order in which the values are given.
  std::stable_sort(
      folders.begin(), folders.end(), [](const FolderAt& a, const FolderAt& b) {
        return std::tie(a.value, a.text) < std::tie(b.value, b.text);
      });
  return folders;
}

// Returns the conditions in the order used by operating-point models.
std::vector<OperatingParameter> GetOperatingParameters(
    const CalibrateArguments& arguments) {
  std::set<OperatingParameter> conditions;
  for (const std::string& name : arguments.condition)
    conditions.insert(*FindOperatingParameter(name));
  return {conditions.begin(), conditions.end()};
}

// Returns "lens_position", "lens_position,temperature".
std::string CollectNames(const std::vector<OperatingParameter>& conditions) {
  std::vector<std::string> names;
  for (const OperatingParameter condition : conditions)
    names.push_back(OperatingParameterName(condition));
  return fmt::format("{}", fmt::join(names, ","));
}

// Returns the columns of the --operating-points file; for a single condition,
// "value" is an alternative to its name.
std::vector<std::string> ParseColumns(
    const std::string& path, const std::string& text,
    const std::vector<OperatingParameter>& conditions) {
  std::vector<std::string> columns;
  for (const OperatingParameter condition : conditions)
    columns.push_back(OperatingParameterName(condition));
  if (columns.size() == 1 &&
      !CsvReader(path, text, {"image"}).HasColumn(columns[0]))
    columns[0] = "value";
  return columns;
}

void ReadValues(const std::string& path,
                const std::vector<OperatingParameter>& conditions,
                std::map<std::string, OperatingPoint>* values) {
  const std::string text = ReadFile(path);
  const std::vector<std::string> columns = ParseColumns(path, text, conditions);
  std::vector<std::string> required = {"image"};
  required.insert(required.end(), columns.begin(), columns.end());
  CsvReader table(path, text, required);
  table.LimitRows(kMaxTableImages);
  while (table.Next()) {
    OperatingPoint image_values;
    for (const std::string& column : columns)
      image_values.push_back(table.Number(column));
    if (!values->emplace(table.Text("image"), image_values).second)
      throw InputError(fmt::format("{}: duplicate row for image {}",
                                   table.Place(), table.Text("image")));
  }
}

// Returns the options that can provide the values.
std::string DescribeValueSources(
    const std::vector<OperatingParameter>& conditions) {
  if (conditions.size() == 1)
    return "--images-at VALUE=FOLDER for each value, or --operating-points "
           "FILE.csv";
  return fmt::format("--operating-points FILE.csv with the columns image,{}",
                     CollectNames(conditions));
}

OperatingPoint ExifValues(const std::string& path, const std::string& bytes,
                          const std::vector<OperatingParameter>& conditions) {
  OperatingPoint values;
  for (const OperatingParameter condition : conditions) {
    const auto value = ReadExifParameter(path, bytes, condition);
    if (!value)
      throw InputError(fmt::format("{}: no {} in EXIF ({}); specify {}", path,
                                   OperatingParameterName(condition),
                                   ExifTagName(condition),
                                   DescribeValueSources(conditions)));
    values.push_back(*value);
  }
  return values;
}

// Returns the values from the images' EXIF data, by path. Files that are not
// images are skipped; feature detection reports them.
std::map<std::string, OperatingPoint> ReadExifValues(
    const std::vector<std::string>& paths,
    const std::vector<OperatingParameter>& conditions) {
  std::map<std::string, OperatingPoint> values;
  for (const std::string& path : paths) {
    std::string bytes;
    try {
      bytes = ReadImageFile(path);
      ParseImageHeader(path, bytes);
    } catch (const InputError&) {
      continue;
    }
    values[path] = ExifValues(path, bytes, conditions);
  }
  return values;
}

}  // namespace

void AddOperatingPointOptions(CLI::App* command,
                              CalibrateArguments* arguments) {
  command
      ->add_option("--vary-with", arguments->condition,
                   "calibrate a camera model that varies with lens_position "
                   "(dioptres), temperature (°C) or both, comma-separated")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"lens_position", "temperature"}))
      ->option_text("QUANTITY");
  command
      ->add_option("--images-at", arguments->cameras_at,
                   "images taken at this value of the quantity passed to "
                   "--vary-with; repeatable, instead of IMAGES")
      ->option_text("VALUE=DIR")
      ->allow_extra_args(false);
  command
      ->add_option("--operating-points", arguments->conditions,
                   "CSV image,value or image,lens_position,temperature for "
                   "--vary-with (default: session or EXIF)")
      ->option_text("FILE");
}

void RequireOperatingPointOptions(const CalibrateArguments& arguments,
                                  bool is_rig) {
  const bool has_values =
      !arguments.cameras_at.empty() || !arguments.conditions.empty();
  if (arguments.condition.empty() && has_values)
    throw Error(ExitCode::kUsage,
                "--images-at and --operating-points require --vary-with "
                "lens_position or --vary-with temperature");
  if (arguments.condition.empty()) return;
  if (is_rig)
    throw Error(ExitCode::kUsage,
                "--vary-with supports a single camera only; calibrate the "
                "cameras of a rig separately");
  const std::vector<OperatingParameter> conditions =
      GetOperatingParameters(arguments);
  if (conditions.size() > 1 && !arguments.cameras_at.empty())
    throw Error(
        ExitCode::kUsage,
        "--images-at takes one value per folder; for two quantities use " +
            DescribeValueSources(conditions));
  if (!arguments.cameras_at.empty() && !arguments.conditions.empty())
    throw Error(ExitCode::kUsage,
                "specify either --images-at or --operating-points, not both");
  if (!has_values && arguments.session_values.empty() &&
      !UsesExifValues(arguments))
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--vary-with {}: the images have no operating point; specify {}",
            CollectNames(conditions), DescribeValueSources(conditions)));
}

bool UsesExifValues(const CalibrateArguments& arguments) {
  return !arguments.condition.empty() && !arguments.images.empty() &&
         arguments.captures.empty() && arguments.cameras_at.empty() &&
         arguments.conditions.empty();
}

Measurements MeasureWithExif(const std::vector<std::string>& images,
                             const CalibrateArguments& arguments,
                             const CommonOptions& common,
                             const Pattern& pattern,
                             const std::function<void(double)>& progress) {
  const std::map<std::string, OperatingPoint> values = ReadExifValues(
      FindImages(images).paths, GetOperatingParameters(arguments));
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
  std::set<double> values;
  for (const FolderAt& folder : folders)
    if (!values.insert(folder.value).second)
      throw Error(ExitCode::kUsage,
                  fmt::format("--images-at {}={}: duplicate value; put its "
                              "images into one folder",
                              folder.text, folder.folder));
  std::vector<NamedValue> places;
  for (const FolderAt& folder : folders)
    places.push_back({folder.text, folder.folder});
  RequireSeparateFolderNames("--images-at", places);
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
      more.condition_values[image.image] = {folders[k].value};
    }
    if (k > 0 && more.dataset.image_size != measurements.dataset.image_size)
      throw InputError(fmt::format(
          "{}: images have {} x {} pixels, but those of {} have {} x {}",
          folders[k].folder, more.dataset.image_size.width,
          more.dataset.image_size.height, folders[0].folder,
          measurements.dataset.image_size.width,
          measurements.dataset.image_size.height));
    Append(std::move(more), &measurements);
  }
  return measurements;
}

std::optional<OperatingPoint> GetOperatingPoint(
    const CalibrateArguments& arguments, const SessionFrame& frame) {
  OperatingPoint values;
  for (const OperatingParameter condition : GetOperatingParameters(arguments)) {
    const std::optional<double>& value =
        condition == OperatingParameter::kLensPosition
            ? frame.lens_position
            : frame.sensor_temperature_c;
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  if (values.empty()) return std::nullopt;
  return values;
}

std::optional<ImageOperatingPoints> ReadOperatingPoints(
    const CalibrateArguments& arguments, const Measurements& measurements) {
  if (arguments.condition.empty()) return std::nullopt;
  ImageOperatingPoints conditions = {GetOperatingParameters(arguments),
                                     measurements.condition_values};
  if (!arguments.conditions.empty())
    ReadValues(arguments.conditions, conditions.conditions, &conditions.values);
  else if (conditions.values.empty())
    conditions.values = arguments.session_values;
  for (const ImagePair& copy : measurements.copies)
    RequireConsistentValues(conditions, copy.first, copy.second);
  return conditions;
}

std::string WarnAboutUnmatchedRows(const CalibrateArguments& arguments,
                                   const ImageOperatingPoints& conditions,
                                   const Measurements& measurements) {
  if (arguments.conditions.empty()) return "";
  std::set<std::string> images;
  for (const ImageFeatures& image : measurements.dataset.images)
    images.insert(image.image);
  for (const auto* others : {&measurements.skipped, &measurements.left_out})
    for (const RejectedImage& image : *others)
      images.insert(std::filesystem::path(image.image).filename().string());
  size_t count = 0;
  std::string first;
  for (const auto& [image, values] : conditions.values)
    if (images.count(image) == 0 && count++ == 0) first = image;
  if (count == 0) return "";
  return fmt::format(
      "{}: {} of {} rows match no image of the calibration, such as {}; check "
      "the names",
      arguments.conditions, count, conditions.values.size(), Printable(first));
}

std::string WarnAboutUnits(const ImageOperatingPoints& conditions) {
  for (const auto& [image, values] : conditions.values)
    for (size_t k = 0; k < values.size(); ++k) {
      const OperatingParameter condition = conditions.conditions[k];
      const bool is_lens = condition == OperatingParameter::kLensPosition;
      const double low = is_lens ? 0 : -100, high = is_lens ? 50 : 150;
      if (values[k] >= low && values[k] <= high) continue;
      return fmt::format(
          "{}: {} {:g} is not plausible in {} (expected {} to {}); use the "
          "same unit whenever the camera is applied",
          Printable(image), OperatingParameterName(condition), values[k],
          is_lens ? "dioptres (1 / metres)" : "°C", low, high);
    }
  return "";
}

}  // namespace raygrid
