#include "packing/pack.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "camera/camera_frame.h"
#include "camera_input.h"
#include "capture_options.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "help_formatter.h"
#include "json_output.h"
#include "mode_options.h"
#include "packing/regular_region.h"
#include "view_options.h"

namespace raygrid {
namespace {

struct PackArguments {
  std::string camera, output, name, serial;
  std::vector<std::string> remaps, modes, capture;
  std::string outside = "fill";
  double max_error_px = 0.05;
  bool is_max_error_given = false;
  bool use_32_bit_grid = false;
};

// Returns the file of a table's view: front.camera.yaml next to front.raygrid;
// with several tables, front.0.camera.yaml and so on. Empty if the output is
// not a regular file.
std::string ViewPath(const std::string& blob, size_t table, size_t num_tables) {
  const std::filesystem::path path(blob);
  if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path))
    return "";
  const std::string number = num_tables == 1 ? "" : fmt::format(".{}", table);
  return (path.parent_path() / (path.stem().string() + number + ".camera.yaml"))
      .string();
}

nlohmann::ordered_json MakeFoundJson(const ProjectedPixels& pixels) {
  return {{"pixels", pixels.num_pixels},
          {"num_not_converged", pixels.num_not_converged},
          {"num_inaccurate", pixels.num_inaccurate},
          {"max_px", pixels.worst_px},
          {"num_not_invertible", pixels.num_not_invertible}};
}

std::string FormatProjection(const ProjectionError& error) {
  std::string text =
      fmt::format("; projection error {:.2g} px", error.valid_region.worst_px);
  if (error.others.num_pixels > 0)
    text += fmt::format(
        " in the valid region, Newton projection converges for {} % of the "
        "other pixels",
        std::floor(1e4 * (1 - error.others.FailedFraction())) / 100);
  return text;
}

void Print(const PackArguments& arguments, const PackedCamera& packed,
           bool json) {
  if (json) {
    nlohmann::ordered_json result = {
        {"bytes", packed.blob.size()},
        {"unproject_error_px", packed.unproject_error_px},
        {"unproject_error_rad", packed.unproject_error_rad}};
    if (packed.projection) {
      result["project_error_px"] = packed.projection->valid_region.worst_px;
      result["projection"] = {
          {"valid_region", MakeFoundJson(packed.projection->valid_region)},
          {"outside_valid_region", MakeFoundJson(packed.projection->others)}};
    }
    result["uncovered_fraction"] = packed.excluded_fraction;
    result["warnings"] = packed.warnings;
    result["remaps"] = nlohmann::ordered_json::array();
    for (const PackedRemap& remap : packed.remaps) {
      nlohmann::ordered_json entry = MakeViewJson(remap.view);
      if (!remap.mode.empty()) entry["mode"] = remap.mode;
      if (remap.distorts) entry["direction"] = "distort";
      if (remap.distant_error_px)
        entry["far_error_px"] = *remap.distant_error_px;
      entry.update({{"error_px", remap.error_px},
                    {"chroma_error_px", remap.chroma_error_px},
                    {"block_px", remap.block_size},
                    {"tile_px", remap.tile_size}});
      result["remaps"].push_back(entry);
    }
    PrintCommandJson(result);
    return;
  }
  fmt::print(
      "{}: {} bytes; unprojection error {:.2g} px, {:.2g} rad relative to {}",
      arguments.output, packed.blob.size(), packed.unproject_error_px,
      packed.unproject_error_rad, arguments.camera);
  if (packed.projection) fmt::print("{}", FormatProjection(*packed.projection));
  for (size_t k = 0; k < packed.remaps.size(); ++k) {
    const PackedRemap& remap = packed.remaps[k];
    fmt::print(
        "; remap table {}{} {} {}x{}: error {:.2g} px, chroma error {:.2g} "
        "chroma pixels, blocks of {} px, tiles of {} px",
        k, remap.mode.empty() ? "" : fmt::format(" of mode {}", remap.mode),
        remap.distorts ? "inverse, from" : "to", remap.view.size.width,
        remap.view.size.height, remap.error_px, remap.chroma_error_px,
        remap.block_size, remap.tile_size);
    if (remap.distant_error_px)
      fmt::print(", error up to {:.2g} px for distant scenes",
                 *remap.distant_error_px);
  }
  fmt::print("\n");
  for (size_t k = 0; k < packed.remaps.size(); ++k)
    fmt::print("view {}: {}\n", k, FormatView(packed.remaps[k].view));
}

std::string RotationWarning(const Eigen::Quaterniond& q) {
  return fmt::format(
      "its camera frame is rotated by {:.2f} degrees from the optical axis "
      "(calibrated by an earlier version), and the blob uses the optical axis: "
      "left-multiply poses by the quaternion ({:.9f}, {:.9f}, {:.9f}, {:.9f}) "
      "(w, x, y, z), or calibrate again",
      q.angularDistance(Eigen::Quaterniond::Identity()) * 180 / M_PI, q.w(),
      q.x(), q.y(), q.z());
}

// Returns the requested views; with sensor modes, at least the camera's default
// view.
std::vector<RemapKeys> ParseViews(const PackArguments& arguments) {
  std::vector<RemapKeys> views;
  for (const std::string& remap : arguments.remaps)
    views.push_back(ParseRemap("--remap", remap));
  if (views.empty() && !arguments.modes.empty()) views.emplace_back();
  return views;
}

// Throws for keys that do not apply to this camera.
void RequirePossible(const CameraModel& camera, const RemapKeys& words) {
  if (words.scene && camera.IsCentral())
    throw Error(
        ExitCode::kUsage,
        "--remap: at and plane require a non-central camera; omit them");
  if (words.distorts && !camera.IsCentral() && !words.scene)
    throw Error(ExitCode::kUsage,
                "--remap: direction=distort for a non-central camera requires "
                "the distance of the scene, at=METRES");
}

RemapRequest MakeRemap(const CameraModel& camera, const RemapKeys& words,
                       const std::optional<SensorMode>& mode) {
  try {
    RemapRequest request(mode ? MakeModeView(camera, *mode, words.view)
                              : MakeView(camera, words.view),
                         mode);
    request.scene = words.scene;
    request.distorts = words.distorts;
    return request;
  } catch (const Error& error) {
    if (!mode) throw;
    throw Error(error.code(),
                fmt::format("--mode {}: {}", mode->name, error.what()));
  }
}

// Returns, for each view, a table for frames as calibrated, followed by one for
// each mode.
std::vector<RemapRequest> MakeRemaps(const CameraModel& camera,
                                     const std::vector<RemapKeys>& views,
                                     const std::vector<SensorMode>& modes) {
  std::vector<RemapRequest> remaps;
  for (const RemapKeys& words : views) {
    RequirePossible(camera, words);
    remaps.push_back(MakeRemap(camera, words, std::nullopt));
    for (const SensorMode& mode : modes)
      remaps.push_back(MakeRemap(camera, words, mode));
  }
  return remaps;
}

void Run(const PackArguments& arguments, const CommonOptions& common) {
  RequireBlobText("--name", arguments.name);
  RequireBlobText("--serial", arguments.serial);
  const std::vector<RemapKeys> views = ParseViews(arguments);
  const size_t num_tables = views.size() * (1 + arguments.modes.size());
  std::vector<std::string> outputs = {arguments.output};
  for (size_t k = 0; k < num_tables; ++k)
    outputs.push_back(ViewPath(arguments.output, k, num_tables));
  RequireNoInputReplaced({arguments.camera}, outputs);
  CameraInput input = ReadCameraOrModel(arguments.camera, common.at);
  if (!common.quiet) WarnAboutFailedCalibration(arguments.camera, input.file);
  if (input.blob)
    throw Error(ExitCode::kUsage,
                arguments.camera + ": is already a blob; pack a camera.yaml");
  if (!arguments.name.empty()) input.file.name = arguments.name;
  if (!arguments.serial.empty()) input.file.serial = arguments.serial;
  input.file.capture = ParseCaptureKeys(arguments.capture, input.file.capture,
                                        input.file.camera->image_size());
  const auto blob_from_camera = AlignToCanonicalFrame(&input.file.camera);
  // The cameras of the other operating points would have to be rotated as well.
  if (blob_from_camera && input.file.stack)
    throw Error(
        ExitCode::kUsage,
        arguments.camera +
            ": its optical axis is not the z axis and it was calibrated over a "
            "range; pack one operating point with --at");
  PackOptions options;
  options.remaps = MakeRemaps(
      *ExtractRegularRegion(*input.file.camera, common.threads), views,
      ParseModes(arguments.modes, input.file.camera->image_size()));
  options.max_error_px = arguments.max_error_px;
  options.is_table_bound_soft = !arguments.is_max_error_given;
  if (arguments.is_max_error_given)
    options.max_ray_error_px = arguments.max_error_px;
  options.shown = SelectVisibleMask(arguments.outside, arguments.camera, input);
  options.is_int16_allowed = !arguments.use_32_bit_grid;
  options.num_threads = common.threads;
  PackedCamera packed = PackCamera(input.file, options);
  if (blob_from_camera)
    packed.warnings.push_back(RotationWarning(*blob_from_camera));
  OutputFiles files;
  files.Add(arguments.output, packed.blob);
  for (size_t k = 0; k < num_tables; ++k)
    if (!outputs[k + 1].empty())
      files.Add(outputs[k + 1],
                ViewCameraFile(packed.remaps[k].view, input.file.name));
  files.Commit();
  for (const std::string& warning : packed.warnings)
    fmt::print(stderr, "raygrid: {}: {}\n", arguments.camera, warning);
  if (!common.quiet || common.json) Print(arguments, packed, common.json);
}

}  // namespace

void AddPack(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "pack", "Pack a camera into a blob for the embedded runtime.",
      "raygrid pack camera.yaml -o front.raygrid --remap 640x480,hfov=60",
      common);
  command->footer(std::string(kViewSyntaxHelp) + kModeSyntaxHelp +
                  kCaptureSyntaxHelp + "\n" + command->get_footer());
  auto arguments = std::make_shared<PackArguments>();
  command
      ->add_option("camera", arguments->camera,
                   "camera.yaml or another tool's camera file")
      ->required();
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  command->add_flag("--grid-32bit", arguments->use_32_bit_grid,
                    "store 32-bit control points: twice the size, unprojection "
                    "in 75 % of the time on microcontrollers");
  BeginGroup(command, help_group::kView);
  command
      ->add_option("--remap", arguments->remaps,
                   "add a remap table for this output view; repeatable. Also "
                   "writes the view as NAME.camera.yaml")
      ->option_text("WxH[,KEY=VALUE...]")
      ->allow_extra_args(false);
  command
      ->add_option("--mode", arguments->modes,
                   "add remap tables of all output views for frames of another "
                   "sensor mode; repeatable")
      ->option_text("NAME:KEY=VALUE,...")
      ->allow_extra_args(false);
  command
      ->add_option("--max-error-px", arguments->max_error_px,
                   "maximum error of a remap table or ray; exceeding it is an "
                   "error if specified, else a warning")
      ->option_text("PX")
      ->check(AboveZero())
      ->capture_default_str();
  AddOutsideOption(command, &arguments->outside);
  BeginGroup(command, help_group::kOutput);
  command->add_option("-o,--output", arguments->output, "blob to write")
      ->option_text("FILE")
      ->required();
  command->add_option("--name", arguments->name, "camera name in the blob")
      ->option_text("NAME");
  command
      ->add_option("--serial", arguments->serial, "serial number in the blob")
      ->option_text("SERIAL");
  command
      ->add_option("--capture-settings", arguments->capture,
                   "capture settings expected of each frame; none: do not "
                   "check them (default: from camera.yaml)")
      ->option_text("KEY=VALUE,...")
      ->allow_extra_args(false);
  AddHugeOption(command);
  command->callback([arguments, command, common] {
    arguments->is_max_error_given = command->count("--max-error-px") > 0;
    Run(*arguments, *common);
  });
}

}  // namespace raygrid
