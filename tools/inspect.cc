#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bytes.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/fixed_operating_point.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"
#include "evaluation/uncertainty_summary.h"
#include "exchange/format.h"
#include "exchange/opencv_model_list.h"
#include "exchange/table_format.h"
#include "json_output.h"
#include "packing/slot_file.h"
#include "target/board_spec.h"
#include "view_options.h"

namespace raygrid {
namespace {

// The contents of a file, printed as JSON or as lines of text.
using Json = nlohmann::ordered_json;

// ---- Blobs -----------------------------------------------------------------

// Adds a metric unless it is unknown.
void AddMetric(const char* key, uint32_t metric, double unit, Json* json) {
  if (metric != RG_UNKNOWN_METRIC) (*json)[key] = metric * unit;
}
void AddFinite(const char* key, double value, Json* json) {
  if (std::isfinite(value)) (*json)[key] = value;
}
void AddPixels(const char* key, uint32_t upx, Json* json) {
  AddMetric(key, upx, 1e-6, json);
}

Json MakeMetricsJson(uint32_t median_upx, uint32_t rms_upx, uint32_t max_upx,
                     uint32_t count) {
  Json json = Json::object();
  AddPixels("median_px", median_upx, &json);
  AddPixels("rms_px", rms_upx, &json);
  AddPixels("max_px", max_upx, &json);
  if (count != RG_UNKNOWN_METRIC) json["features"] = count;
  return json;
}

Json MakeRemapJson(const uint8_t* section,
                   const std::vector<SensorMode>& modes) {
  rg_remap_section remap;
  rg_read_remap(section, &remap);
  Json json = {{"size", {remap.width, remap.height}},
               {"focal_length_px", remap.fx_q16 / 65536.0},
               {"center_px", {remap.cx_q16 / 65536.0, remap.cy_q16 / 65536.0}},
               {"block_px", 1 << remap.block_log2},
               {"vertices", {remap.columns, remap.rows}}};
  json.update(MakeViewJson(GetTableView(remap)));
  if (remap.mode != 0) json["mode"] = Printable(modes[remap.mode - 1].name);
  if (remap.direction == RG_DISTORT) json["direction"] = "distort";
  if (remap.part_log2 != 0) json["tile_px"] = 1 << remap.part_log2;
  AddPixels("error_px", remap.max_error_upx, &json);
  AddPixels("error_limit_px", remap.bound_upx, &json);
  return json;
}

Json MakeModeJson(const SensorMode& mode) {
  return {{"name", Printable(mode.name)},
          {"size", {mode.size.width, mode.size.height}},
          {"offset_px", {mode.offset_px.x(), mode.offset_px.y()}},
          {"scale", {mode.scale.x(), mode.scale.y()}},
          {"flip_x", mode.flip_x},
          {"flip_y", mode.flip_y}};
}

void AddQuality(const rg_blob& blob, Json* json) {
  rg_quality_section quality;
  rg_blob_quality(&blob, &quality);
  const auto add = [&](const char* key, const Json& known) {
    if (!known.empty()) (*json)[key] = known;
  };
  add("training_error",
      MakeMetricsJson(quality.training_median_upx, quality.training_rms_upx,
                      quality.training_max_upx, quality.training_count));
  add("held_out_error",
      MakeMetricsJson(quality.held_out_median_upx, quality.held_out_rms_upx,
                      quality.held_out_max_upx, quality.held_out_count));
  Json packing = Json::object();
  AddMetric("max_px", quality.packing_error_npx, 1e-9, &packing);
  AddMetric("max_rad", quality.packing_error_prad, 1e-12, &packing);
  add("packing_error", packing);
}

Json MakeUncertaintyJson(const rg_blob& blob) {
  rg_uncertainty_section uncertainty;
  rg_blob_uncertainty(&blob, &uncertainty);
  std::vector<uint32_t> values_q12;  // without unknown values
  for (int i = 0; i < uncertainty.columns * uncertainty.rows; ++i) {
    const uint32_t value = rg_load_u16(uncertainty.values + 2 * i);
    if (value != RG_UNKNOWN_UNCERTAINTY) values_q12.push_back(value);
  }
  std::sort(values_q12.begin(), values_q12.end());
  Json json = {{"grid", {uncertainty.columns, uncertainty.rows}}};
  if (!values_q12.empty())
    json["median_px"] = values_q12[values_q12.size() / 2] / 4096.0;
  return json;
}

// Returns the maximum stored uncertainty in the valid region.
std::optional<double> ComputeMaxValidUncertainty(const rg_blob& blob,
                                                 const rg_mask_section& mask) {
  if (!blob.uncertainty) return std::nullopt;
  rg_grid_section grid;
  rg_blob_grid(&blob, &grid);
  rg_uncertainty_section uncertainty;
  rg_blob_uncertainty(&blob, &uncertainty);
  const Area area = {grid.x0_q16 / 65536.0, grid.y0_q16 / 65536.0,
                     grid.x1_q16 / 65536.0, grid.y1_q16 / 65536.0};
  UncertaintyLattice lattice = {uncertainty.columns, uncertainty.rows, {}};
  for (int i = 0; i < uncertainty.columns * uncertainty.rows; ++i) {
    const uint32_t value = rg_load_u16(uncertainty.values + 2 * i);
    lattice.stddev_px.push_back(
        value == RG_UNKNOWN_UNCERTAINTY ? NAN : value / 4096.0);
  }
  const int knot_spacing_px = 1 << mask.cell_log2;
  double largest_px = -1;
  for (int k = 0; k < mask.columns * mask.rows; ++k) {
    if ((mask.bits[k / 8] >> k % 8 & 1) == 0) continue;
    const Eigen::Vector2d center(
        std::clamp((k % mask.columns + 0.5) * knot_spacing_px - 0.5, area.x0,
                   area.x1),
        std::clamp((k / mask.columns + 0.5) * knot_spacing_px - 0.5, area.y0,
                   area.y1));
    const double px = lattice.At(area, center);
    if (std::isfinite(px)) largest_px = std::max(largest_px, px);
  }
  if (largest_px < 0) return std::nullopt;
  return largest_px;
}

Json MakeMaskJson(const rg_blob& blob) {
  rg_mask_section mask;
  rg_blob_mask(&blob, &mask);
  const int count = mask.columns * mask.rows;
  int num_valid = 0;
  for (int k = 0; k < count; ++k) num_valid += mask.bits[k / 8] >> k % 8 & 1;
  Json json = {{"cells", num_valid},
               {"grid", {mask.columns, mask.rows}},
               {"cell_px", 1 << mask.cell_log2}};
  if (const auto limit_px = ComputeMaxValidUncertainty(blob, mask))
    json["max_uncertainty_px"] = *limit_px;
  return json;
}

void AddLineDelay(const LineDelay& line_delay, Json* json) {
  (*json)["line_delay_us"] = line_delay.seconds * 1e6;
  if (line_delay.stddev_s > 0)
    (*json)["line_delay_sd_us"] = line_delay.stddev_s * 1e6;
}

Json MakeCaptureJson(const Capture& capture) {
  Json json = Json::object();
  if (capture.lens_position) {
    json["lens_position_dpt"] = *capture.lens_position;
    json["lens_tolerance_dpt"] = capture.lens_tolerance;
  }
  if (capture.crop) json["crop"] = *capture.crop;
  if (capture.zoom) json["zoom"] = *capture.zoom;
  if (capture.orientation) json["orientation"] = *capture.orientation;
  if (capture.sensor_temperature_c)
    json["sensor_temperature_c"] = *capture.sensor_temperature_c;
  if (capture.exposure_us) json["exposure_us"] = *capture.exposure_us;
  if (capture.analogue_gain) json["analogue_gain"] = *capture.analogue_gain;
  return json;
}

Json MakeOperatingPointJson(const rg_blob& blob) {
  rg_stack_section stack;
  rg_blob_stack(&blob, &stack);
  const bool is_position =
      stack.condition == RG_OPERATING_PARAMETER_LENS_POSITION;
  Json json = {
      {"quantity", is_position ? "lens_position_dpt" : "sensor_temperature_c"},
      {"samples", Json::array()},
      {"bytes_per_sample", stack.sample_size}};
  for (int k = 0; k < stack.num_samples; ++k)
    json["samples"].push_back(rg_stack_sample_value(&stack, k) / 65536.0);
  return json;
}

Json MakeBlobJson(const BlobCamera& camera) {
  const rg_blob& blob = camera.blob();
  rg_camera_section identity;
  rg_grid_section grid;
  rg_blob_camera(&blob, &identity);
  rg_blob_grid(&blob, &grid);
  const uint16_t fraction_bits =
      rg_load_u16(blob.bytes + blob.grid + RG_GRID_FRACTION_BITS);
  const bool is_int16 = fraction_bits != RG_CONTROL_POINT_BITS;
  const std::string version =
      fmt::format("{}.{}", rg_load_u16(blob.bytes + RG_HEADER_MAJOR),
                  rg_load_u16(blob.bytes + RG_HEADER_MINOR));
  Json json = {{"kind", "blob"},
               {"valid", true},
               {"bytes", blob.size},
               {"format_version", version},
               {"can_project", camera.CanProject()},
               {"camera",
                {{"name", Printable(identity.name)},
                 {"serial", Printable(identity.serial)},
                 {"image_size", {identity.width, identity.height}}}},
               {"grid",
                {{"values", blob.line_points ? "lines" : "directions"},
                 {"control_points", {grid.columns, grid.rows}},
                 {"bits", is_int16 ? 16 : 32},
                 {"area_px",
                  {grid.x0_q16 / 65536.0, grid.y0_q16 / 65536.0,
                   grid.x1_q16 / 65536.0, grid.y1_q16 / 65536.0}}}},
               {"remap_tables", Json::array()}};
  const std::vector<SensorMode> modes = camera.Modes();
  for (const SensorMode& mode : modes)
    json["modes"].push_back(MakeModeJson(mode));
  for (uint32_t k = 0;; ++k) {
    const uint8_t* remap = rg_find_section(blob.bytes, RG_SECTION_REMAP, k);
    if (!remap) break;
    json["remap_tables"].push_back(MakeRemapJson(remap, modes));
  }
  if (blob.quality) AddQuality(blob, &json);
  if (blob.uncertainty) json["uncertainty"] = MakeUncertaintyJson(blob);
  if (blob.mask) json["valid_region"] = MakeMaskJson(blob);
  if (const auto capture = camera.GetCalibrationCapture())
    json["capture"] = MakeCaptureJson(*capture);
  if (blob.stack) json["operating_points"] = MakeOperatingPointJson(blob);
  if (const auto line_delay = camera.GetRowTime())
    AddLineDelay(*line_delay, &json);
  return json;
}

// ---- Other files -----------------------------------------------------------

Json MakeMetricsJson(const ErrorMetrics& metrics) {
  return {{"median_px", metrics.median_px},
          {"rms_px", metrics.rms_px},
          {"max_px", metrics.max_px},
          {"features", metrics.count}};
}

// Returns the named parameters of a parametric model; of OpenCV's model, in its
// order.
Json MakeParametricModelJson(const ParametricModel& lens) {
  const std::vector<std::string>& names = lens.ParameterNames();
  const Eigen::VectorXd named = lens.Parameters().tail(names.size());
  Json json = Json::object();
  for (const std::string& name : lens.Name() == models::kOpenCv
                                     ? MakeOpenCvModel("", 8).parameters
                                     : names)
    json[name] =
        named[std::find(names.begin(), names.end(), name) - names.begin()];
  return json;
}

// Adds the ranges of an operating-point model, and its number of parameters.
void AddRanges(const CameraFile& file, Json* json) {
  const OperatingPointModel& stack = file.stack->cameras;
  int num_terms = 1;
  for (size_t r = 0; r < stack.ranges().size(); ++r) {
    const OperatingRange& range = stack.ranges()[r];
    num_terms += stack.orders()[r];
    (*json)["operating_ranges"].push_back(
        {{"quantity", OperatingParameterName(range.condition)},
         {"range", {range.low, range.high}},
         {"polynomial_order", stack.orders()[r]}});
  }
  (*json)["parameters"] = num_terms * file.camera->NumParameters();
  const auto known = ComputeMaxUncertainty(file);
  if (!known || !known->HasStdDevs()) return;
  Json& everywhere = (*json)["uncertainty_over_operating_range"];
  AddFinite("median_px", known->lattice.MedianPx(), &everywhere);
  everywhere["valid_fraction"] = ComputeValidShare(*file.camera, known->mask);
}

Json MakeCameraJson(const CameraFile& file) {
  const ImageSize& size = file.camera->image_size();
  const Area& area = file.camera->area();
  Json json = {{"kind", "camera"},
               {"model", file.camera->Name()},
               {"parameters", file.camera->NumParameters()},
               {"camera",
                {{"name", file.name},
                 {"serial", file.serial},
                 {"image_size", {size.width, size.height}}}},
               {"area_px", {area.x0, area.y0, area.x1, area.y1}}};
  if (const auto& circle = file.camera->image_circle())
    json["image_circle"] = {
        {"center_px", {circle->center.x(), circle->center.y()}},
        {"radius_px", circle->radii_px.x()}};
  if (const ParametricModel* lens = file.camera->Parametric())
    json["intrinsics"] = MakeParametricModelJson(*lens);
  if (file.training) json["training_error"] = MakeMetricsJson(*file.training);
  if (file.held_out) json["held_out_error"] = MakeMetricsJson(*file.held_out);
  if (file.uncertainty && file.uncertainty->HasStdDevs()) {
    AddFinite("median_px", file.uncertainty->lattice.MedianPx(),
              &json["uncertainty"]);
    json["uncertainty"]["valid_limit_px"] = file.uncertainty->max_stddev_px;
  }
  if (file.uncertainty)
    json["uncertainty"]["valid_fraction"] =
        ComputeValidShare(*file.camera, file.uncertainty->mask);
  if (file.stack) AddRanges(file, &json);
  if (file.capture) json["capture"] = MakeCaptureJson(*file.capture);
  if (file.line_delay) AddLineDelay(*file.line_delay, &json);
  if (file.camera_from_view) {
    const Eigen::Vector3d turned =
        ViewAnglesDeg(file.camera_from_view->rotation.toRotationMatrix());
    json["view_rotation_deg"] = {
        {"right", turned[0]}, {"up", turned[1]}, {"clockwise", turned[2]}};
  }
  return json;
}

Json MakePatternJson(const Pattern& pattern) {
  Json json = {{"kind", "pattern"}, {"boards", Json::array()}};
  for (const Board& board : pattern.boards)
    json["boards"].push_back({{"id", board.id},
                              {"kind", board.kind},
                              {"features", {board.columns, board.rows}},
                              {"square_m", board.square_m}});
  for (const RigidTarget& body : pattern.rigid_targets)
    json["rigid_targets"].push_back(body.boards);
  return json;
}

// Returns the camera centre x, y, z in the rig's frame, without negative zeros.
Json CenterInRig(const Pose& camera_from_rig) {
  const Eigen::Vector3d center =
      camera_from_rig.Inverse().translation + Eigen::Vector3d::Zero();
  return {center.x(), center.y(), center.z()};
}

Json MakeRelativePoseFacts(const std::vector<RigFileCamera>& cameras,
                           const RelativePoseCovariance& pair) {
  Pose poses[2];
  for (const RigFileCamera& camera : cameras) {
    if (camera.name == pair.first) poses[0] = camera.camera_from_rig;
    if (camera.name == pair.second) poses[1] = camera.camera_from_rig;
  }
  const Pose second_from_first = poses[1] * poses[0].Inverse();
  const Eigen::Vector3d& translation = second_from_first.translation;
  return {{"cameras", {pair.first, pair.second}},
          {"distance_m", translation.norm()},
          {"distance_sd_m", pair.DistanceStdDev(translation)},
          {"angle_rad", second_from_first.rotation.angularDistance(
                            Eigen::Quaterniond::Identity())},
          {"rotation_sd_rad", pair.RotationStdDev()}};
}

Json MakeRigJson(const std::vector<RigFileCamera>& cameras,
                 const std::vector<RelativePoseCovariance>& relative_poses) {
  Json json = {{"kind", "rig"}, {"cameras", Json::array()}};
  for (const RigFileCamera& camera : cameras)
    json["cameras"].push_back(
        {{"name", camera.name},
         {"file", camera.file},
         {"center_in_rig_m", CenterInRig(camera.camera_from_rig)}});
  for (const RelativePoseCovariance& pair : relative_poses)
    json["relative_poses"].push_back(MakeRelativePoseFacts(cameras, pair));
  return json;
}

Json MakeFeaturesJson(const std::map<std::string, Dataset>& cameras) {
  Json json = {{"kind", "features"}, {"cameras", Json::array()}};
  for (const auto& [camera, dataset] : cameras)
    json["cameras"].push_back({{"name", camera},
                               {"features", dataset.num_features()},
                               {"images", dataset.images.size()}});
  return json;
}

// Returns the facts of a file in another program's format.
Json MakeForeignJson(const Format& format, const std::string& path,
                     const std::string& text) {
  RequireCameraFormat(format, path);
  const ExchangeContents contents =
      ReadExchangeFile(&format, {path, text, "", std::nullopt});
  RequireCameras(contents, path);
  Json json = {{"kind", contents.IsRig() ? "rig" : "camera"},
               {"format", format.name}};
  if (contents.cameras.size() == 1) {
    json.update(MakeCameraJson(MakeCameraFile(contents.cameras.front())));
  } else {
    json["cameras"] = Json::array();
    for (const InputCamera& read : contents.cameras) {
      const CameraFile file = MakeCameraFile(read);
      const ImageSize& size = file.camera->image_size();
      json["cameras"].push_back({{"name", read.name},
                                 {"model", file.camera->Name()},
                                 {"image_size", {size.width, size.height}}});
      if (read.camera_from_rig)
        json["cameras"].back()["center_in_rig_m"] =
            CenterInRig(*read.camera_from_rig);
    }
  }
  if (!contents.warnings.empty()) json["warnings"] = contents.warnings;
  return json;
}

// ---- Slots -----------------------------------------------------------------

Json MakeSlotJson(const std::string& path, const BlobSlot& slot) {
  if (!slot.is_whole)
    return {{"state", slot.is_erased ? "erased" : "incomplete"}};
  Json json = {{"state", slot.IsUsable() ? "valid" : "unreadable"},
               {"sequence", slot.sequence},
               {"bytes", slot.blob.size()}};
  if (!slot.IsUsable()) {
    json["fault"] = slot.fault;
    return json;
  }
  const BlobCamera camera(path, slot.blob);
  rg_camera_section identity;
  rg_blob_camera(&camera.blob(), &identity);
  json["name"] = Printable(identity.name);
  json["serial"] = Printable(identity.serial);
  json["image_size"] = {identity.width, identity.height};
  return json;
}

Json MakeSlotsJson(const std::string& path, const std::string& bytes) {
  const auto place = FindMisplacedSlot(bytes);
  if (place || bytes.size() % 8 != 0)
    throw InputError(fmt::format(
        "{}: has {} bytes, not two equal slots{}; use an exact copy of both "
        "slots",
        path, bytes.size(),
        place ? fmt::format(": one begins at byte {}", *place) : ""));
  const BlobSlots read = ReadSlots(bytes);
  Json json = {{"kind", "slots"}, {"slot_size", bytes.size() / 2}};
  if (read.newest) json["newest"] = *read.newest;
  for (size_t k = 0; k < read.slots.size(); ++k)
    json[fmt::format("slot_{}", k)] = MakeSlotJson(path, read.slots[k]);
  return json;
}

// Reads the two slots at the beginning of a block device.
std::string ReadDeviceSlots(const std::string& path,
                            const std::optional<uint64_t>& slot_size) {
  if (!slot_size)
    throw Error(
        ExitCode::kUsage,
        path + ": is a block device; specify the slot size with --slot-size");
  std::string bytes(2 * *slot_size, '\0');
  std::ifstream device(path, std::ios::binary);
  if (!device.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    throw InputError(
        fmt::format("{}: cannot read {} bytes; use a smaller --slot-size, or "
                    "check its permissions",
                    path, bytes.size()));
  return bytes;
}

bool IsBlockDevice(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_block_file(path, error);
}

// ---- Kinds of files --------------------------------------------------------

Json MakeBudgetSummary(const std::string& path,
                       const std::optional<uint64_t>& slot_size) {
  if (IsBoardSpec(path)) return MakePatternJson(ParseBoardSpec(path));
  if (IsBlockDevice(path))
    return MakeSlotsJson(path, ReadDeviceSlots(path, slot_size));
  if (slot_size)
    throw Error(ExitCode::kUsage,
                "--slot-size is for block devices only; a file consists of two "
                "equal slots");
  const std::string bytes = ReadFile(path);
  if (IsSlotFile(bytes)) return MakeSlotsJson(path, bytes);
  if (IsBlob(path, bytes)) return MakeBlobJson(BlobCamera(path, bytes));
  if (bytes.find("raygrid_camera:") != std::string::npos)
    return MakeCameraJson(ParseCameraFile(path, bytes));
  if (bytes.find("raygrid_rig:") != std::string::npos)
    return MakeRigJson(ParseRigFile(path, bytes),
                       ParseRelativePoseCovariances(path, bytes));
  if (bytes.find("raygrid_pattern:") != std::string::npos)
    return MakePatternJson(ParsePattern(path, bytes));
  if (const Format* format = RecognizeFormat(bytes))
    return MakeForeignJson(*format, path, bytes);
  if (const TableFormat* table = RecognizeTable(bytes))
    throw InputError(
        fmt::format("{}: {}", path, table->ExplainMissingCamera()));
  if (bytes.find("board") != std::string::npos)
    return MakeFeaturesJson(ParseFeatures(path, bytes));
  throw InputError(path +
                   ": not a blob, camera, rig, pattern or features file, nor "
                   "one of these formats: " +
                   ListFormatNames());
}

// ---- Text ------------------------------------------------------------------

std::string FormatValue(const Json& value, int digits = 6) {
  if (value.is_string()) return "'" + Printable(value.get<std::string>()) + "'";
  if (value.is_boolean()) return value ? "yes" : "no";
  if (value.is_number_float())
    return fmt::format("{:.{}g}", double(value), digits);
  if (!value.is_array()) return value.dump();
  const bool is_size = value.size() == 2 && value[0].is_number_integer();
  std::string text;
  for (const Json& element : value)
    text += (text.empty() ? "" : is_size ? " x " : ", ") + FormatValue(element);
  return text;
}

// Splits a key into name and unit: "median_px" into "median" and " px".
std::pair<std::string, std::string> NameAndUnit(std::string key) {
  std::string unit;
  for (const auto& [known, sign] :
       {std::pair("px", "px"), std::pair("rad", "rad"), std::pair("m", "m"),
        std::pair("dpt", "dpt"), std::pair("us", "us"), std::pair("c", "°C")}) {
    const std::string ending = std::string("_") + known;
    if (key.size() <= ending.size() ||
        key.compare(key.size() - ending.size(), ending.size(), ending) != 0)
      continue;
    unit = std::string(" ") + sign;
    key.resize(key.size() - ending.size());
    break;
  }
  std::replace(key.begin(), key.end(), '_', ' ');
  return {key, unit};
}

// Whether a value is an error or an uncertainty, printed with three significant
// digits.
bool IsStatistic(const std::string& name) {
  return name == "median" || name == "rms" || name == "max" || name == "error";
}

std::string FormatObject(const Json& object, int digits = 6) {
  std::string text;
  for (const auto& [key, value] : object.items()) {
    const auto [name, unit] = NameAndUnit(key);
    text += (text.empty() ? "" : ", ") + name + " " +
            FormatValue(value, IsStatistic(name) ? 3 : digits) + unit;
  }
  return text;
}

void PrintText(const Json& facts) {
  for (const auto& [key, value] : facts.items()) {
    const auto [name, unit] = NameAndUnit(key);
    if (value.is_object()) {
      // Intrinsics are printed with all digits, to be copied to other programs.
      fmt::print("{}: {}\n", name,
                 FormatObject(value, key == "intrinsics" ? 12 : 6));
    } else if (value.is_array() && (value.empty() || value[0].is_object())) {
      for (const Json& element : value)
        fmt::print("{}: {}\n", name, FormatObject(element));
    } else {
      fmt::print("{}: {}{}\n", name, FormatValue(value), unit);
    }
  }
}

void Inspect(const std::string& path, const std::optional<uint64_t>& slot_size,
             const CommonOptions& common) {
  const Json facts = MakeBudgetSummary(path, slot_size);
  if (common.json)
    PrintCommandJson(facts);
  else
    PrintText(facts);
  if (facts["kind"] == "slots" && !facts.contains("newest"))
    throw Error(ExitCode::kInvalidBlob,
                path +
                    ": neither slot contains a valid blob; "
                    "write one with raygrid update");
}

}  // namespace

void AddInspect(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "inspect", "Describe a raygrid file, and verify it if it is a blob.",
      "raygrid inspect front.raygrid", common);
  auto path = std::make_shared<std::string>();
  command
      ->add_option("file", *path,
                   "blob, camera, rig, pattern or features file, flash slots, "
                   "or a target specification such as chessboard:9x6:25mm")
      ->required();
  auto slot_size = std::make_shared<std::optional<uint64_t>>();
  command
      ->add_option("--slot-size", *slot_size,
                   "size of a slot of a block device, such as 64K or 1M")
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::Range(uint64_t{8}, uint64_t{1} << 30))
      ->option_text("BYTES");
  command->callback(
      [path, slot_size, common] { Inspect(*path, *slot_size, *common); });
}

}  // namespace raygrid
