#include "dataset/image_files.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// Catches what the image libraries print to standard error while they decode:
// for some damage that is all they do about it.
class DecoderMessages {
 public:
  DecoderMessages() : lock_(Mutex()) {
    std::fflush(stderr);
    saved_ = dup(STDERR_FILENO);
    file_ = memfd_create("decoder-messages", MFD_CLOEXEC);
    if (saved_ >= 0 && file_ >= 0) dup2(file_, STDERR_FILENO);
  }
  ~DecoderMessages() {
    if (saved_ >= 0) close(saved_);
    if (file_ >= 0) close(file_);
  }
  DecoderMessages(const DecoderMessages&) = delete;
  DecoderMessages& operator=(const DecoderMessages&) = delete;

  // Standard error is itself again; true if a library spoke of damage.
  bool Stop() {
    std::fflush(stderr);
    if (saved_ < 0 || file_ < 0) return false;
    dup2(saved_, STDERR_FILENO);
    char text[4096] = {};
    if (pread(file_, text, sizeof(text) - 1, 0) <= 0) return false;
    for (const char* damage : {"Premature end", "Corrupt", "corrupt",
                               "extraneous bytes", "Not enough data"})
      if (std::strstr(text, damage)) return true;
    return false;
  }

 private:
  static std::mutex& Mutex() {
    static std::mutex mutex;
    return mutex;
  }
  std::lock_guard<std::mutex> lock_;
  int saved_, file_;
};

// A JPEG file without an end-of-image mark was cut; the decoder would fill up
// what is missing with grey and say nothing.
bool IsCutJpeg(const std::string& bytes) {
  constexpr size_t kMaxTrailingBytes = 4096;
  if (bytes.compare(0, 2, "\xff\xd8") != 0) return false;
  const size_t end = bytes.rfind("\xff\xd9");
  return end == std::string::npos || end + kMaxTrailingBytes < bytes.size();
}

bool HasImageExtension(const fs::path& path) {
  static const std::set<std::string> extensions = {".png", ".jpg",  ".jpeg",
                                                   ".tif", ".tiff", ".bmp",
                                                   ".pgm", ".ppm",  ".webp"};
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extensions.count(extension) > 0;
}

std::vector<std::string> ImagesInFolder(const std::string& folder) {
  std::vector<std::string> images;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (HasImageExtension(entry.path()))
      images.push_back(entry.path().string());
  if (error)
    throw InputError(
        fmt::format("{}: cannot be read ({})", folder, error.message()));
  std::sort(images.begin(), images.end());
  return images;
}

// As OpenCV has it, but never a damaged image; flags are cv::imdecode()'s.
cv::Mat Decode(const std::string& name, const std::string& bytes, int flags) {
  cv::Mat decoded;
  bool is_damaged = IsCutJpeg(bytes);
  if (!bytes.empty() && !is_damaged) {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U,
                          const_cast<char*>(bytes.data()));
    DecoderMessages messages;
    try {
      decoded = cv::imdecode(encoded, flags | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      decoded.release();
    }
    is_damaged = messages.Stop();
  }
  if (decoded.empty() || is_damaged)
    throw InputError(name +
                     ": not an image, or damaged; remove it or replace it");
  return decoded;
}

// The largest value that a camera can have meant by 16 bits of which it used
// no more than this.
double FullScale(double brightest) {
  for (const int bits : {8, 10, 12, 14})
    if (brightest < 1 << bits) return (1 << bits) - 1;
  return 65535;
}

double FullScale(const cv::Mat& image) {
  if (image.depth() == CV_8U) return 255;
  double brightest = 0;
  cv::minMaxIdx(image, nullptr, &brightest);
  return FullScale(brightest);
}

}  // namespace

Image ReadImage(const std::string& path, bool grey) {
  const cv::Mat decoded = Decode(
      path, ReadFile(path), grey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR);
  Image image;
  image.size = {decoded.cols, decoded.rows};
  image.channels = decoded.channels();
  image.pixels.assign(decoded.datastart, decoded.dataend);
  return image;
}

GreyLevels DecodeGreyLevels(const std::string& name, const std::string& bytes) {
  const cv::Mat decoded =
      Decode(name, bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
  if (decoded.depth() != CV_8U && decoded.depth() != CV_16U)
    throw InputError(name +
                     ": pixels of neither 8 nor 16 bits; convert it to PNG");
  GreyLevels grey;
  grey.size = {decoded.cols, decoded.rows};
  grey.levels.resize(decoded.total());
  cv::Mat levels(decoded.size(), CV_32F, grey.levels.data());
  decoded.convertTo(levels, CV_32F, 255 / FullScale(decoded));
  return grey;
}

GreyLevels ReadGreyLevels(const std::string& path) {
  return DecodeGreyLevels(path, ReadFile(path));
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
      throw InputError(path +
                       ": no images in this folder (png, jpg, tif, bmp, "
                       "pgm); name another");
    images.insert(images.end(), found.begin(), found.end());
  }
  std::sort(images.begin(), images.end(),
            [](const std::string& a, const std::string& b) {
              return std::make_pair(fs::path(a).filename(), a) <
                     std::make_pair(fs::path(b).filename(), b);
            });
  return images;
}

}  // namespace raygrid
