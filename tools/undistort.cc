#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "packing/pack.h"
#include "progress_bar.h"

namespace raygrid {
namespace {

struct Arguments {
  std::string camera, output, size, frames;
  std::string rectify = "pinhole";
  std::vector<std::string> images;
  double hfov_deg = 0;
  double max_error_px = 0.05;
  uint32_t remap_index = 0;
};

// The blob itself, if it has a table and no other one is asked for.
BlobCamera PrepareBlob(const Arguments& arguments,
                       const CommonOptions& common) {
  CameraInput input = ReadCamera(arguments.camera);
  if (input.blob && input.blob->has_remap() && arguments.size.empty() &&
      arguments.hfov_deg == 0)
    return *std::move(input.blob);
  if (!input.blob) TurnIntoCameraFrame(&input.file);
  ImageSize size;
  if (!arguments.size.empty()) size = ParseImageSize("--size", arguments.size);
  PackOptions options;
  options.remaps = {
      MakeVirtualCamera(*input.file.camera, size, arguments.hfov_deg)};
  options.max_error_px = arguments.max_error_px;
  options.num_threads = common.threads;
  return BlobCamera("packed camera", PackCamera(input.file, options).blob);
}

void RequireSize(const std::string& path, const ImageSize& size,
                 const ImageSize& expected) {
  if (size != expected)
    throw Error(ExitCode::kBlob,
                fmt::format("{}: {} x {} pixels, but the camera is calibrated "
                            "for {} x {}; use images of that mode",
                            path, size.width, size.height, expected.width,
                            expected.height));
}

// The image as a board gets it from a grey camera: bytes, row by row.
void AddRawFrame(const Arguments& arguments, const std::string& path,
                 OutputFiles* files) {
  const Image grey = ReadImage(path, true);
  const std::filesystem::path target =
      std::filesystem::path(arguments.frames) /
      (std::filesystem::path(path).stem().string() + ".raw");
  files->Add(target.string(),
             std::string(grey.pixels.begin(), grey.pixels.end()));
}

void Run(const Arguments& arguments, const CommonOptions& common) {
  if (arguments.rectify != "pinhole")
    throw Error(ExitCode::kUsage, "--rectify: this version knows pinhole");
  RequireWritableFolder(arguments.output);
  const BlobCamera camera = PrepareBlob(arguments, common);
  const std::vector<std::string> paths = FindImages(arguments.images);
  ProgressBar bar(common.quiet);
  nlohmann::ordered_json written = {{"images", nlohmann::json::array()}};
  for (size_t i = 0; i < paths.size(); ++i) {
    const Image image = ReadImage(paths[i], false);
    RequireSize(paths[i], image.size, camera.image_size());
    const Image result = camera.Undistort(image, 0, arguments.remap_index);
    const std::filesystem::path path =
        std::filesystem::path(arguments.output) /
        (std::filesystem::path(paths[i]).stem().string() + ".png");
    OutputFiles files;
    files.Add(path.string(), EncodePng(result));
    if (!arguments.frames.empty()) AddRawFrame(arguments, paths[i], &files);
    files.Commit();
    written["images"].push_back({{"image", paths[i]}, {"file", path.string()}});
    bar.Show("undistortion", static_cast<double>(i + 1) / paths.size());
  }
  if (common.json)
    fmt::print("{}\n", written.dump(2, ' ', false,
                                    nlohmann::json::error_handler_t::replace));
  else if (!common.quiet)
    fmt::print("{} images undistorted to {}\n", paths.size(), arguments.output);
}

}  // namespace

void AddUndistort(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "undistort",
      "Undistorts images with the code that runs on the board.",
      "raygrid undistort camera.yaml photos/ -o flat/ --hfov 80", common);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("camera", arguments->camera, "camera.yaml or a blob")
      ->required();
  command->add_option("images", arguments->images, "images or folders")
      ->required();
  command->add_option("-o,--output", arguments->output, "folder for PNG files")
      ->required();
  command->add_option("--size", arguments->size,
                      "WxH of the output (default: as the images)");
  command
      ->add_option("--hfov", arguments->hfov_deg,
                   "horizontal field of view in degrees (default: as sharp "
                   "in the middle as the image)")
      ->check(CLI::PositiveNumber);
  command->add_option("--frames", arguments->frames,
                      "folder for the images as raw grey frames, which "
                      "raygrid-undistort takes");
  command->add_option("--remap-index", arguments->remap_index,
                      "which of a blob's tables, from 0 on");
  command
      ->add_option("--rectify", arguments->rectify, "virtual camera: pinhole")
      ->capture_default_str();
  command
      ->add_option("--max-error-px", arguments->max_error_px,
                   "geometric error that the table may have")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
