#include "report/thumbnails.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "dataset/error.h"
#include "dataset/image_codecs.h"
#include "dataset/image_files.h"
#include "dataset/image_memory_budget.h"
#include "dataset/parallel_for.h"
#include "report/html.h"
#include "report/plots.h"

namespace raygrid {
namespace {

constexpr double kMaxBytes = 3e6;  // total size of all thumbnails
constexpr int kMaxWidthPx = 640, kMinWidthPx = 16;

std::string EncodeThumbnail(const Image& image) {
  constexpr int kQuality = 55;
  const cv::Mat pixels(image.size.height, image.size.width, CV_8U,
                       const_cast<uint8_t*>(image.pixels.data()));
  return EncodeJpeg(pixels, kQuality);
}

// Returns the width at which `count` images of this shape fit into the limit.
int ComputeWidth(int count, const ImageSize& size) {
  constexpr double kBytesPerPixel = 0.12;
  const double pixels = kMaxBytes / std::max(1, count) / kBytesPerPixel;
  const double aspect = double(size.width) / std::max(1, size.height);
  return static_cast<int>(std::sqrt(pixels * aspect));
}

size_t SumBytes(const std::vector<std::string>& files) {
  size_t total = 0;
  for (const std::string& file : files) total += file.size();
  return total;
}

}  // namespace

Thumbnails MakeThumbnails(const Dataset& dataset,
                          const std::vector<std::string>& paths,
                          int num_threads) {
  const int count = static_cast<int>(paths.size());
  int width_px = std::clamp(ComputeWidth(count, dataset.image_size),
                            kMinWidthPx, kMaxWidthPx);
  std::vector<Image> images(count);
  std::vector<std::string> files(count);
  ParallelFor(count, NumThreads(num_threads), [&](int i) {
    try {
      const ImageMemoryBudget room(dataset.image_size);
      images[i] = ShrinkImage(ReadImage(paths[i], true), width_px);
      files[i] = EncodeThumbnail(images[i]);
    } catch (const InputError&) {
      // Deleted images have no thumbnail.
    }
  });
  while (SumBytes(files) > kMaxBytes && width_px > kMinWidthPx) {
    width_px = std::max(
        kMinWidthPx,
        static_cast<int>(0.95 * width_px *
                         std::sqrt(kMaxBytes / double(SumBytes(files)))));
    ParallelFor(count, NumThreads(num_threads), [&](int i) {
      if (!files[i].empty())
        files[i] = EncodeThumbnail(ShrinkImage(images[i], width_px));
    });
  }
  Thumbnails thumbnails;
  if (SumBytes(files) > kMaxBytes) return thumbnails;
  for (int i = 0; i < count; ++i)
    if (!files[i].empty()) thumbnails[dataset.images[i].image] = files[i];
  return thumbnails;
}

std::string FormatThumbnails(const Thumbnails& thumbnails) {
  nlohmann::ordered_json json = {{"raygrid_thumbnails", 1}};
  json["images"] = nlohmann::ordered_json::object();
  for (const auto& [name, bytes] : thumbnails)
    json["images"][name] = Base64(bytes);
  return json.dump(0) + "\n";
}

ThumbnailTexts ParseThumbnails(const std::string& path,
                               const std::string& json) {
  try {
    const auto parsed = nlohmann::json::parse(json);
    if (parsed.at("raygrid_thumbnails") != 1)
      throw InputError(path +
                       ": written by another version; rerun the calibration");
    return parsed.at("images").get<ThumbnailTexts>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(path + ": malformed; rerun the calibration, or remove it");
  }
}

}  // namespace raygrid
