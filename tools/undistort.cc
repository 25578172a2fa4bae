#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bag_input.h"
#include "camera/camera_frame.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/file_parts.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/text_encoding.h"
#include "help_formatter.h"
#include "interruption.h"
#include "json_output.h"
#include "mode_options.h"
#include "packing/distorted_image.h"
#include "packing/pack.h"
#include "packing/regular_region.h"
#include "progress_bar.h"
#include "undistorted_bag.h"
#include "view_options.h"

namespace raygrid {
namespace {

constexpr char kViewFile[] = "view.camera.yaml";

struct UndistortArguments {
  std::string camera, output, frames;
  std::string rectify = "pinhole", outside = "fill";
  std::vector<std::string> images;
  ViewKeyValues view;
  BagOptions bags;
  std::string mode;
  double max_error_px = 0.05;
  bool is_max_error_given = false;
  uint32_t remap_index = 0;
  bool is_reverse = false;
};

// A view and the mapping of images to it, or from it.
struct ImageMapper {
  VirtualView view;
  // Maps an image; its path is used in error messages.
  std::function<Image(const std::string& path, const Image& image)> map;
};

bool HasViewOptions(const UndistortArguments& arguments) {
  for (const auto& [name, value] : arguments.view)
    if (!value.empty()) return true;
  return false;
}

void RequireSize(const std::string& path, const ImageSize& size,
                 const ImageSize& expected, const char* owner,
                 const char* remedy) {
  if (size != expected)
    throw Error(ExitCode::kInvalidBlob,
                fmt::format("{}: {} x {} pixels, but {} {} x {}; {}", path,
                            size.width, size.height, owner, expected.width,
                            expected.height, remedy));
}

// Maps by a remap table of a blob.
ImageMapper MapWithTable(BlobCamera blob, const VirtualView& view,
                         uint32_t remap_index) {
  const auto camera = std::make_shared<BlobCamera>(std::move(blob));
  return {view, [=](const std::string& path, const Image& image) {
            RequireSize(path, image.size, camera->FrameSize(remap_index),
                        "the remap table requires",
                        camera->IsInverseRemap(remap_index)
                            ? "use undistorted images of this size"
                            : "use images of this size, or define their sensor "
                              "mode with --mode");
            return camera->Undistort(image, 0, remap_index);
          }};
}

// Returns the mapper that distorts undistorted images of the view.
ImageMapper Distortion(const CameraModel& camera, const VirtualView& view,
                       int num_threads) {
  const auto map =
      std::make_shared<SourceMap>(MakeDistortionMap(camera, view, num_threads));
  return {view, [=](const std::string& path, const Image& picture) {
            RequireSize(path, picture.size, view.size,
                        "the undistorted view has",
                        "use undistorted images of this size, or describe "
                        "their view, e.g. with --size or --view");
            return DistortImage(*map, picture, num_threads);
          }};
}

// Whether each pixel of the camera's frames, as calibrated or of a sensor mode,
// is in the valid region.
std::vector<bool> ComputeValidPixels(const ValidityMask& valid_region,
                                     const SensorMode& mode) {
  std::vector<bool> pixels;
  for (int y = 0; y < mode.size.height; ++y)
    for (int x = 0; x < mode.size.width; ++x)
      pixels.push_back(
          valid_region.IsValidAt(mode.ToCalibrated(Eigen::Vector2d(x, y))));
  return pixels;
}

// Sets pixels outside the valid region to the border value in images of the
// camera, as calibrated or of a sensor mode.
ImageMapper ValidOnly(ImageMapper mapper, const std::string& path,
                      const ValidityMask& valid_region,
                      const SensorMode& mode) {
  const std::vector<bool> pixels = ComputeValidPixels(valid_region, mode);
  if (std::find(pixels.begin(), pixels.end(), true) == pixels.end())
    throw Error(
        ExitCode::kUsage,
        path +
            ": --outside border: the valid region is empty; omit the option");
  const auto map = mapper.map;
  mapper.map = [=](const std::string& image_path, const Image& picture) {
    Image image = map(image_path, picture);
    const size_t pixel_bytes = image.pixels.size() / pixels.size();
    for (size_t k = 0; k < pixels.size(); ++k)
      if (!pixels[k])
        std::fill_n(&image.pixels[k * pixel_bytes], pixel_bytes, uint8_t{0});
    return image;
  };
  return mapper;
}

void RequireNoFrames(const UndistortArguments& arguments) {
  if (!arguments.frames.empty())
    throw Error(ExitCode::kUsage, "--frames cannot be combined with --inverse");
}

void RequireCentral(const UndistortArguments& arguments,
                    const CameraModel& camera) {
  if (!camera.IsCentral())
    throw Error(ExitCode::kUsage,
                fmt::format("{}: --inverse is not defined for a non-central "
                            "camera; fit a central camera with raygrid fit",
                            arguments.camera));
}

// Returns the requested sensor mode: one of the blob's modes, or the one
// specified by the option.
std::optional<SensorMode> SelectMode(const UndistortArguments& arguments,
                                     const CameraInput& input) {
  if (arguments.mode.empty()) return std::nullopt;
  if (!input.blob || HasViewOptions(arguments))
    return ParseModes({arguments.mode}, input.file.camera->image_size())[0];
  std::vector<std::string> names;
  for (const SensorMode& mode : input.blob->Modes()) {
    if (mode.name == arguments.mode) return mode;
    names.push_back(mode.name);
  }
  throw Error(ExitCode::kInvalidBlob,
              fmt::format("{}: no remap table for sensor mode '{}' ({}); add "
                          "one with raygrid pack --mode, or use camera.yaml",
                          arguments.camera, arguments.mode,
                          names.empty() ? "it has no sensor modes"
                                        : fmt::format("it has {}",
                                                      fmt::join(names, ", "))));
}

// Returns the remap table of the blob selected by index or sensor mode.
uint32_t SelectRemapTable(const BlobCamera& blob,
                          const UndistortArguments& arguments) {
  return arguments.mode.empty()
             ? arguments.remap_index
             : blob.FindModeTable(arguments.mode).value_or(RG_NO_TABLE);
}

// Rejects an inverse table unless distortion is requested: applying it would
// distort the camera's image twice.
void RequireDirection(const UndistortArguments& arguments, uint32_t table,
                      bool distorts) {
  if (distorts && !arguments.is_reverse)
    throw Error(ExitCode::kUsage,
                fmt::format("{}: table {} is an inverse remap (distort); add "
                            "--inverse, or select another with --remap-index",
                            arguments.camera, table));
}

// The requested view or remap table; the sensor mode of the frames; and the
// valid region, if the output is restricted to it.
struct UndistortRequest {
  ViewRequest view;
  std::optional<uint32_t> table;
  std::optional<SensorMode> mode;
  std::optional<ValidityMask> valid_region;
};

// Uses the blob's table if no other view is requested.
void CompleteRequest(const UndistortArguments& arguments,
                     const CameraInput& input, UndistortRequest* request) {
  request->mode = SelectMode(arguments, input);
  request->valid_region =
      SelectVisibleMask(arguments.outside, arguments.camera, input);
  if (!input.blob || !input.blob->has_remap() || HasViewOptions(arguments))
    return;
  const uint32_t table = SelectRemapTable(*input.blob, arguments);
  RequireDirection(arguments, table, input.blob->IsInverseRemap(table));
  if (!request->mode) request->mode = input.blob->GetRemapMode(table);
  request->table = table;
}

VirtualView SelectView(const CameraInput& input,
                       const UndistortRequest& request) {
  if (request.table) return input.blob->GetRemapView(*request.table);
  const CameraModel& camera = *input.file.camera;
  return request.mode ? MakeModeView(camera, *request.mode, request.view)
                      : MakeView(camera, request.view);
}

// Maps from the view to the camera, with the blob's table if it is an inverse
// remap.
ImageMapper PrepareDistortion(const UndistortArguments& arguments,
                              const UndistortRequest& request,
                              CameraInput input, int num_threads) {
  if (request.table && input.blob->IsInverseRemap(*request.table)) {
    const VirtualView view = SelectView(input, request);
    return MapWithTable(*std::move(input.blob), view, *request.table);
  }
  RequireCentral(arguments, *input.file.camera);
  if (!input.blob) AlignToCanonicalFrame(&input.file.camera);
  input.file.camera = ExtractRegularRegion(*input.file.camera, num_threads);
  const CameraModel& camera = *input.file.camera;
  const VirtualView view = SelectView(input, request);
  return request.mode
             ? Distortion(ModeCamera(camera, *request.mode), view, num_threads)
             : Distortion(camera, view, num_threads);
}

// Maps from the camera to the view, with the blob's table unless the output is
// restricted to the valid region; otherwise with a new table.
ImageMapper PrepareUndistortion(const UndistortArguments& arguments,
                                const UndistortRequest& request,
                                CameraInput input, int num_threads) {
  if (request.table && !request.valid_region) {
    const VirtualView view = SelectView(input, request);
    return MapWithTable(*std::move(input.blob), view, *request.table);
  }
  if (!input.blob) AlignToCanonicalFrame(&input.file.camera);
  const VirtualView view = SelectView(input, request);
  PackOptions options;
  options.remaps.emplace_back(view, request.mode);
  options.max_error_px = arguments.max_error_px;
  options.is_table_bound_soft = !arguments.is_max_error_given;
  options.shown = request.valid_region;
  options.num_threads = num_threads;
  const PackedCamera packed = PackCamera(input.file, options);
  if (packed.remaps[0].error_px > arguments.max_error_px)
    fmt::print(stderr,
               "raygrid: {}: remap error up to {:.2g} px; reduce the field of "
               "view for a smaller error\n",
               arguments.camera, packed.remaps[0].error_px);
  return MapWithTable(BlobCamera("packed camera", packed.blob), view, 0);
}

ImageMapper Prepare(const UndistortArguments& arguments,
                    const CommonOptions& common) {
  UndistortRequest request;
  request.view = ParseViewOptions(arguments.view);
  CameraInput input = ReadCamera(arguments.camera, common.at);
  if (!common.quiet) WarnAboutFailedCalibration(arguments.camera, input.file);
  if (arguments.is_reverse) RequireNoFrames(arguments);
  CompleteRequest(arguments, input, &request);
  if (!arguments.is_reverse)
    return PrepareUndistortion(arguments, request, std::move(input),
                               common.threads);
  SensorMode mode;
  mode.size = input.file.camera->image_size();
  ImageMapper mapper =
      PrepareDistortion(arguments, request, std::move(input), common.threads);
  return request.valid_region
             ? ValidOnly(mapper, arguments.camera, *request.valid_region,
                         request.mode.value_or(mode))
             : mapper;
}

// The output paths of an image, and of its raw frame if requested.
struct Targets {
  std::string image, frame;
};

std::string Target(const std::string& folder, const std::string& path,
                   const char* extension) {
  const std::filesystem::path name = std::filesystem::path(path).filename();
  // Images of bags are named by their stamps.
  const bool is_part = FilesOf(path) != std::vector<std::string>{path};
  const std::string stem = (is_part ? name : name.stem()).string();
  return (std::filesystem::path(folder) / (stem + extension)).string();
}

// Throws if two images would have the same output, or an input would be
// overwritten.
std::vector<Targets> MakeTargets(const UndistortArguments& arguments,
                                 const std::vector<std::string>& paths) {
  std::vector<Targets> targets;
  std::map<std::string, std::string> path_by_target;
  for (const std::string& path : paths) {
    targets.push_back({Target(arguments.output, path, ".png"), ""});
    if (!arguments.frames.empty())
      targets.back().frame = Target(arguments.frames, path, ".raw");
    const std::string& target = targets.back().image;
    const auto [place, is_new] = path_by_target.emplace(target, path);
    if (!is_new)
      throw InputError(
          fmt::format("{} and {} would both be written to {}; rename one, or "
                      "use two output folders",
                      place->second, path, target));
  }
  std::vector<std::string> inputs = paths, outputs;
  inputs.push_back(arguments.camera);
  for (const Targets& target : targets)
    outputs.insert(outputs.end(), {target.image, target.frame});
  outputs.push_back(
      (std::filesystem::path(arguments.output) / kViewFile).string());
  RequireNoInputReplaced(inputs, outputs);
  RequireSeparateFolders(paths, arguments.output);
  return targets;
}

// Returns the image as the frame of a grey camera, row by row: 8 bits, or 16
// bits in little-endian order.
std::string RawFrame(const std::string& path) {
  const Image grey = ReadGreyAsStored(path);
  std::string frame(grey.pixels.begin(), grey.pixels.end());
  if (grey.sample_bytes == 1) return frame;
  for (size_t i = 0; i < frame.size(); i += 2) {
    uint16_t sample;
    std::memcpy(&sample, &grey.pixels[i], sizeof(sample));
    frame[i] = static_cast<char>(sample & 255);
    frame[i + 1] = static_cast<char>(sample >> 8);
  }
  return frame;
}

// Throws if images are raw colour mosaics, whose pixels cannot be interpolated.
void RequireNoMosaic(const BagFrames& frames) {
  for (const auto& [path, frame] : frames)
    if (frame.encoding.rfind("bayer_", 0) == 0)
      throw InputError(fmt::format(
          "{}: encoding {} is a raw mosaic; undistort a colour or grey topic",
          path, frame.encoding));
}

// Throws unless images of bags are undistorted to a bag.
void RequireBagInput(const UndistortArguments& arguments,
                     const std::vector<std::string>& paths,
                     const BagFrames& frames) {
  for (const std::string& path : paths)
    if (frames.count(path) == 0)
      throw Error(ExitCode::kUsage,
                  fmt::format("-o {}: messages need stamps, which {} lacks; "
                              "pass a bag, or write to a folder",
                              arguments.output, path));
  if (arguments.is_reverse || !arguments.frames.empty())
    throw Error(
        ExitCode::kUsage,
        fmt::format("-o {}: {} is not supported for bags", arguments.output,
                    arguments.is_reverse ? "--inverse" : "--frames"));
  std::vector<std::string> inputs = paths;
  inputs.push_back(arguments.camera);
  RequireNoInputReplaced(inputs, {arguments.output});
}

// Undistorts images of bags to a bag.
void RunToBag(const UndistortArguments& arguments, const CommonOptions& common,
              const std::vector<std::string>& paths, const BagFrames& frames) {
  RequireBagInput(arguments, paths, frames);
  const ImageMapper mapper = Prepare(arguments, common);
  InstallInterruptHandler();
  UndistortedBag bag(arguments.output, mapper.view);
  nlohmann::ordered_json written = {{"images", nlohmann::json::array()},
                                    {"view", MakeViewJson(mapper.view)},
                                    {"view_file", arguments.output}};
  size_t num_skipped = 0;
  std::string failure;
  {
    ProgressBar bar(common.quiet);
    for (size_t i = 0; i < paths.size(); ++i) {
      if (IsInterrupted())
        throw Error(ExitCode::kOutputFailed,
                    arguments.output + ": interrupted; was not written");
      try {
        bag.Add(frames.at(paths[i]),
                mapper.map(paths[i], ReadImageAsStored(paths[i])));
        written["images"].push_back(
            {{"image", paths[i]}, {"file", arguments.output}});
      } catch (const InputError& error) {
        if (num_skipped++ == 0) failure = error.what();
      }
      bar.Show("undistortion", static_cast<double>(i + 1) / paths.size());
    }
  }
  if (num_skipped == paths.size()) throw InputError(failure);
  if (num_skipped > 0)
    fmt::print(stderr, "raygrid: skipped {} images, the first: {}\n",
               num_skipped, Printable(failure));
  bag.Finish();
  if (common.json)
    PrintCommandJson(written);
  else if (!common.quiet)
    fmt::print("{} images undistorted to {}; view: {}\n",
               paths.size() - num_skipped, arguments.output,
               FormatView(mapper.view));
}

void Run(const UndistortArguments& arguments, const CommonOptions& common) {
  if (arguments.rectify != "pinhole")
    throw Error(ExitCode::kUsage, "--rectify: only pinhole is supported");
  BagFrames frames;
  const FoundImages found = FindImages(
      ExpandBags(arguments.images, arguments.bags, common.quiet, &frames));
  const std::vector<std::string>& paths = found.paths;
  RequireNoMosaic(frames);
  if (IsBagOutput(arguments.output)) {
    RunToBag(arguments, common, paths, frames);
    return;
  }
  const std::vector<Targets> targets = MakeTargets(arguments, paths);
  RequireCreatableFolder(arguments.output);
  const ImageMapper mapper = Prepare(arguments, common);
  for (const SkippedImage& image : found.left_out)
    fmt::print(stderr, "raygrid: skipped {}: {}\n", image.path, image.reason);
  std::vector<std::string> turned;
  ProgressBar bar(common.quiet);
  const std::string view_path =
      (std::filesystem::path(arguments.output) / kViewFile).string();
  nlohmann::ordered_json written = {{"images", nlohmann::json::array()},
                                    {"view", MakeViewJson(mapper.view)},
                                    {"view_file", view_path}};
  for (size_t i = 0; i < paths.size(); ++i) {
    const Image image = ReadImageAsStored(paths[i]);
    const Image mapped = mapper.map(paths[i], image);
    if (image.is_turned) turned.push_back(paths[i]);
    OutputFiles files;
    if (i == 0) files.Add(view_path, ViewCameraFile(mapper.view, ""));
    files.Add(targets[i].image, EncodePng(mapped));
    if (!targets[i].frame.empty())
      files.Add(targets[i].frame, RawFrame(paths[i]));
    files.Commit();
    written["images"].push_back(
        {{"image", paths[i]}, {"file", targets[i].image}});
    bar.Show(arguments.is_reverse ? "distortion" : "undistortion",
             static_cast<double>(i + 1) / paths.size());
  }
  if (!turned.empty() && !common.quiet)
    fmt::print(stderr, "raygrid: {}\n", WarnAboutOrientation(turned));
  if (common.json)
    PrintCommandJson(written);
  else if (!common.quiet)
    fmt::print("{} images {} to {}; view, in {}: {}\n", paths.size(),
               arguments.is_reverse ? "distorted" : "undistorted",
               arguments.output, kViewFile, FormatView(mapper.view));
}

}  // namespace

void AddUndistort(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "undistort",
      "Undistort images with the remap code of the embedded runtime.",
      "raygrid undistort camera.yaml photos/ -o flat/ --hfov 80", common);
  auto arguments = std::make_shared<UndistortArguments>();
  command->add_option("camera", arguments->camera, "camera.yaml or blob")
      ->required();
  command->add_option("images", arguments->images, "images, folders or bags")
      ->required();
  command
      ->add_option("--mode", arguments->mode,
                   "sensor mode of the images: NAME of a mode in the blob, or "
                   "a definition as for raygrid pack --mode")
      ->option_text("NAME");
  command->add_flag(
      "--inverse", arguments->is_reverse,
      "apply distortion: render camera images from undistorted images");
  AddBagOptions(command, &arguments->bags, false);
  BeginGroup(command, help_group::kView);
  AddAtOption(command, common);
  command
      ->add_option("--remap-index", arguments->remap_index,
                   "0-based index of the remap table in the blob")
      ->option_text("N");
  AddViewOptions(command, &arguments->view);
  AddOutsideOption(command, &arguments->outside);
  command->add_option("--rectify", arguments->rectify, "pinhole; has no effect")
      ->group("");
  command
      ->add_option("--max-error-px", arguments->max_error_px,
                   "maximum error of the remap table; exceeding it is an error "
                   "if specified, else a warning")
      ->option_text("PX")
      ->check(AboveZero())
      ->capture_default_str();
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "folder for PNG files and view.camera.yaml, the camera of "
                   "the undistorted images; .mcap: a bag with its CameraInfo")
      ->option_text("PATH")
      ->required();
  command
      ->add_option("--frames", arguments->frames,
                   "also write the inputs as raw grey frames (8 or 16 bits), "
                   "as input for raygrid-undistort")
      ->option_text("DIR");
  AddHugeOption(command);
  command->callback([arguments, command, common] {
    arguments->is_max_error_given = command->count("--max-error-px") > 0;
    Run(*arguments, *common);
  });
}

}  // namespace raygrid
