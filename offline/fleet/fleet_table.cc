#include "fleet/fleet_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "dataset/camera_file.h"
#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/fixed_operating_point.h"
#include "dataset/text_encoding.h"
#include "report/result_keys.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

// The columns of fleet.csv with metrics, between reason and lens_batch.
const std::vector<std::string> kColumns = {"focal_px",
                                           "center_x_px",
                                           "center_y_px",
                                           "held_out_median_px",
                                           "held_out_rms_px",
                                           "held_out_max_px",
                                           "max_uncertainty_px",
                                           "valid_fraction",
                                           "images",
                                           "sensor_temperature_c"};

// Adds the number at a path of nested keys, if there is one.
void AddNumber(const Json& json, const std::vector<std::string>& keys,
               const std::string& name, UnitRow* row) {
  const Json* at = &json;
  for (const std::string& key : keys) {
    if (!at->is_object() || !at->contains(key)) return;
    at = &at->at(key);
  }
  if (at->is_number()) row->metrics[name] = at->get<double>();
}

void AddResult(const Json& result, UnitRow* row) {
  for (const char* metric : {"median_px", "rms_px", "max_px"})
    AddNumber(result, {"held_out", metric}, std::string("held_out_") + metric,
              row);
  AddNumber(result, {"training", "median_px"}, "training_median_px", row);
  AddNumber(result, {"images", "used"}, "images", row);
  AddNumber(result, {"uncertainty", "valid_fraction"}, "valid_fraction", row);
  row->status = result.value("verdict", "");
  if (row->status == "fail" && !result.at("reasons").empty())
    row->reason = result.at("reasons")[0].get<std::string>();
  // The reason is the warning that the lens is an outlier of the prior's
  // population; other warnings are not included.
  const Json& distance = result.value("population_distance", Json::object());
  if (row->status == "warn") row->reason = distance.value("warning", "");
}

// Returns the pixels per radian at the z axis, as the geometric mean over both
// image axes.
std::optional<double> FocalLength(const CameraModel& camera) {
  constexpr double kStep = 1e-3;
  double area = 0;
  const auto left = camera.Project({-kStep, 0, 1}),
             right = camera.Project({kStep, 0, 1}),
             above = camera.Project({0, -kStep, 1}),
             below = camera.Project({0, kStep, 1});
  if (!left || !right || !above || !below) return std::nullopt;
  const Eigen::Vector2d across = *right - *left, down = *below - *above;
  area = across.x() * down.y() - across.y() * down.x();
  return area > 0 ? std::optional(std::sqrt(area) / (2 * kStep)) : std::nullopt;
}

void AddCamera(const CameraFile& file, UnitRow* row) {
  if (const auto center = file.camera->Project({0, 0, 1})) {
    row->metrics["center_x_px"] = center->x();
    row->metrics["center_y_px"] = center->y();
  }
  if (file.capture && file.capture->sensor_temperature_c)
    row->metrics["sensor_temperature_c"] = *file.capture->sensor_temperature_c;
  if (const auto focal = FocalLength(*file.camera))
    row->metrics["focal_px"] = *focal;
  double worst = 0;
  if (const auto known =
          file.stack ? ComputeMaxUncertainty(file) : file.uncertainty)
    for (const double deviation : known->lattice.stddev_px)
      if (std::isfinite(deviation)) worst = std::max(worst, deviation);
  if (worst > 0) row->metrics["max_uncertainty_px"] = worst;
}

// Returns the first metric outside its limits; empty if all are within.
std::string ExplainOutOfRange(const UnitRow& row, const MetricLimits& limits) {
  for (const auto& [name, range] : limits) {
    const auto metric = row.metrics.find(name);
    if (metric == row.metrics.end()) return name + " is unknown";
    if (metric->second > range.second)
      return fmt::format("{} is {:.6g}, above {:.6g}", name, metric->second,
                         range.second);
    if (metric->second < range.first)
      return fmt::format("{} is {:.6g}, below {:.6g}", name, metric->second,
                         range.first);
  }
  return "";
}

// Formats a text field. Spreadsheets execute text that looks like a formula,
// unless it begins with an apostrophe.
std::string TextField(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  const bool is_formula =
      first != std::string::npos &&
      std::string("=+-@").find(text[first]) != std::string::npos;
  return CsvField(is_formula ? "'" + text : text);
}

}  // namespace

UnitRow ReadUnitRow(const std::string& serial, const std::string& folder,
                    const MetricLimits& limits) {
  UnitRow row;
  row.serial = serial;
  const std::string path = folder + "/result.json";
  try {
    const std::string text = ReadFile(path);
    RequireSmallTree(path, text);
    Json result = Json::parse(text);
    UpgradeResult(&result);
    AddResult(result, &row);
  } catch (const Json::exception&) {
    throw InputError(
        path + ": not a result of raygrid calibrate; run the batch again");
  }
  if (std::filesystem::exists(folder + "/camera.yaml"))
    AddCamera(ReadCameraFile(folder + "/camera.yaml"), &row);
  const std::string beyond = ExplainOutOfRange(row, limits);
  if (!beyond.empty() && row.status != "fail") {
    row.status = "fail";
    row.reason = beyond;
  }
  return row;
}

std::string FormatFleetTable(const std::vector<UnitRow>& rows) {
  std::string text = fmt::format(
      "serial,status,reason,{},lens_batch,outlying_metrics,elapsed_s\n",
      fmt::join(kColumns, ","));
  for (const UnitRow& row : rows) {
    text +=
        fmt::format("{},{},{}", row.serial, row.status, TextField(row.reason));
    for (const std::string& column : kColumns) {
      const auto metric = row.metrics.find(column);
      text += metric == row.metrics.end()
                  ? ","
                  : fmt::format(",{:.9g}", metric->second);
    }
    text += "," + TextField(row.lens_batch) + "," +
            TextField(fmt::format("{}", fmt::join(row.outliers, " ")));
    text += row.seconds > 0 ? fmt::format(",{:.2f}\n", row.seconds) : ",\n";
  }
  return text;
}

}  // namespace raygrid
