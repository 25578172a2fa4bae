#include "mode_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "dataset/error.h"

namespace raygrid {
namespace {

// Transforms the features of images [first, end) from calibrated frames to
// frames of their sensor mode, or back.
using MovePixel = Eigen::Vector2d (SensorMode::*)(const Eigen::Vector2d&) const;
void MovePixels(const SensorMode& mode, MovePixel move, size_t first,
                size_t end, Dataset* dataset) {
  for (size_t i = first; i < end; ++i)
    for (Feature& feature : dataset->images[i].features)
      feature.pixel = (mode.*move)(feature.pixel);
}

// Refines the features of images [first, end) in frames of their own mode.
void RefineMode(const Measurements& measurements, const ModeImages& of_mode,
                size_t end, const EstimatedScene& scene, int num_threads,
                const std::function<void(double)>& go_on, Dataset* refined) {
  const ModeCamera camera(*scene.camera, of_mode.mode);
  const auto part = [&](const auto& all) {
    return std::vector(all.begin() + static_cast<std::ptrdiff_t>(of_mode.first),
                       all.begin() + static_cast<std::ptrdiff_t>(end));
  };
  Dataset frames = {of_mode.mode.size, part(measurements.dataset.images)};
  const size_t count = frames.images.size();
  MovePixels(of_mode.mode, &SensorMode::FromCalibrated, 0, count, &frames);
  frames = RefineFeaturesWithCamera(part(measurements.paths), frames,
                                    {&camera, scene.pattern, scene.poses}, {},
                                    num_threads, go_on);
  MovePixels(of_mode.mode, &SensorMode::ToCalibrated, 0, count, &frames);
  std::move(
      frames.images.begin(), frames.images.end(),
      refined->images.begin() + static_cast<std::ptrdiff_t>(of_mode.first));
}

// Whether two paths are equal except for a trailing slash.
bool IsSamePath(const std::string& a, const std::string& b) {
  const auto normal = [](const std::string& path) {
    return (std::filesystem::path(path) / "").lexically_normal();
  };
  return normal(a) == normal(b);
}

void RequireOtherNames(const Measurements& measurements,
                       const Measurements& more, const std::string& folder) {
  std::set<std::string> names;
  for (const ImageFeatures& image : measurements.dataset.images)
    names.insert(image.image);
  for (const ImageFeatures& image : more.dataset.images)
    if (names.count(image.image))
      throw InputError(fmt::format(
          "{}: image name {} is also used in another sensor mode; rename one",
          folder, image.image));
}

}  // namespace

ModeFolders GroupByMode(const std::vector<std::string>& images,
                        const std::vector<std::string>& modes) {
  ModeFolders folders = {images, {}};
  for (const std::string& text : modes) {
    const std::string folder = text.substr(0, text.rfind(':'));
    const auto found = std::find_if(
        folders.calibrated.begin(), folders.calibrated.end(),
        [&](const std::string& path) { return IsSamePath(path, folder); });
    if (found == folders.calibrated.end())
      throw Error(ExitCode::kUsage,
                  fmt::format("--mode {}: {} is not one of the image folders; "
                              "expected FOLDER:SETTINGS, each folder once",
                              text, folder));
    folders.calibrated.erase(found);
    folders.modes.emplace_back(folder, text);
  }
  if (folders.calibrated.empty() && !modes.empty())
    throw Error(ExitCode::kUsage,
                "--mode: all images were taken in other sensor modes; some "
                "must be taken in the mode to calibrate");
  return folders;
}

void AppendModeMeasurements(const SensorMode& mode, const std::string& folder,
                            Measurements more, Measurements* measurements) {
  const ImageSize& size = more.dataset.image_size;
  if (size != mode.size)
    throw InputError(fmt::format(
        "{}: images have {} x {} pixels, but the sensor mode {} x {}; correct "
        "--mode",
        folder, size.width, size.height, mode.size.width, mode.size.height));
  RequireOtherNames(*measurements, more, folder);
  measurements->modes.push_back({mode, measurements->dataset.images.size()});
  MovePixels(mode, &SensorMode::ToCalibrated, 0, more.dataset.images.size(),
             &more.dataset);
  Append(std::move(more), measurements);
}

Dataset RefineModes(const Measurements& measurements,
                    const EstimatedScene& scene, int num_threads,
                    const std::function<void(double)>& go_on) {
  const std::vector<ModeImages>& modes = measurements.modes;
  const size_t count = measurements.paths.size();
  const auto num_calibrated =
      static_cast<std::ptrdiff_t>(NumCalibratedImages(measurements));
  Dataset calibrated = measurements.dataset, refined = measurements.dataset;
  calibrated.images.resize(static_cast<size_t>(num_calibrated));
  calibrated = RefineFeaturesWithCamera(
      {measurements.paths.begin(), measurements.paths.begin() + num_calibrated},
      calibrated, scene, {}, num_threads, go_on);
  std::move(calibrated.images.begin(), calibrated.images.end(),
            refined.images.begin());
  for (size_t k = 0; k < modes.size(); ++k)
    RefineMode(measurements, modes[k],
               k + 1 < modes.size() ? modes[k + 1].first : count, scene,
               num_threads, go_on, &refined);
  return refined;
}

}  // namespace raygrid
