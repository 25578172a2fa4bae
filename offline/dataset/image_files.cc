#include "dataset/image_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

bool HasImageExtension(const fs::path& path) {
  static const std::set<std::string> extensions = {
      ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".webp"};
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extensions.count(extension) > 0;
}

std::vector<std::string> ImagesInFolder(const std::string& folder) {
  std::vector<std::string> images;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (HasImageExtension(entry.path())) images.push_back(entry.path().string());
  if (error)
    throw InputError(
        fmt::format("{}: cannot be read ({})", folder, error.message()));
  std::sort(images.begin(), images.end());
  return images;
}

}  // namespace

Image ReadImage(const std::string& path, bool grey) {
  const std::string bytes = ReadFile(path);
  cv::Mat decoded;
  if (!bytes.empty()) {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U,
                          const_cast<char*>(bytes.data()));
    try {
      decoded = cv::imdecode(
          encoded, (grey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR) |
                       cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      decoded.release();
    }
  }
  if (decoded.empty())
    throw InputError(path +
                     ": not an image, or damaged; remove it or replace it");
  Image image;
  image.size = {decoded.cols, decoded.rows};
  image.channels = decoded.channels();
  image.pixels.assign(decoded.datastart, decoded.dataend);
  return image;
}

std::string EncodePng(const Image& image) {
  const cv::Mat pixels(image.size.height, image.size.width,
                       CV_8UC(image.channels),
                       const_cast<uint8_t*>(image.pixels.data()));
  std::vector<uint8_t> encoded;
  cv::imencode(".png", pixels, encoded);
  return std::string(encoded.begin(), encoded.end());
}

std::vector<std::string> FindImages(const std::vector<std::string>& paths) {
  std::vector<std::string> images;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      images.push_back(path);
      continue;
    }
    const std::vector<std::string> found = ImagesInFolder(path);
    if (found.empty())
      throw InputError(path + ": no images in this folder (png, jpg, tif, bmp, "
                              "pgm); name another");
    images.insert(images.end(), found.begin(), found.end());
  }
  return images;
}

}  // namespace raygrid
