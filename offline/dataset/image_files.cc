#include "dataset/image_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <climits>
#include <filesystem>
#include <opencv2/core.hpp>
#include <set>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_codecs.h"
#include "dataset/image_header.h"
#include "dataset/mosaic.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// How a JPEG file ends: with a marker, after its only scan, or truncated. The
// decoder fills missing parts with grey and warns only about sequential scans
// with all components.
enum class JpegEnd { kWithEndMarker, kAfterSingleScan, kTruncated };

// Bytes after the end-of-image marker are ignored: phones append megabytes of
// metadata and video. Thumbnails with end markers are within segments, which
// are skipped.
JpegEnd FindJpegEnd(const std::string& bytes) {
  const auto byte = [&bytes](size_t at) {
    return at < bytes.size() ? static_cast<uint8_t>(bytes[at]) : 0;
  };
  const auto is_frame = [](int marker) {
    return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 &&
           marker != 0xc8 && marker != 0xcc;
  };
  int num_components = 0;
  bool is_any_scan = false, is_only_scan = false;
  for (size_t at = 2; at + 1 < bytes.size();) {
    const int marker = byte(at + 1);
    const bool has_no_length =
        marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    if (byte(at) != 0xff || marker == 0 || marker == 0xff) {
      ++at;  // scan data or padding
    } else if (marker == 0xd9) {
      return is_any_scan ? JpegEnd::kWithEndMarker : JpegEnd::kTruncated;
    } else if (has_no_length) {
      at += 2;
    } else {
      const bool is_sequential = marker == 0xc0 || marker == 0xc1;
      if (is_frame(marker)) num_components = is_sequential ? byte(at + 9) : -1;
      if (marker == 0xda) {
        is_only_scan = byte(at + 4) == num_components;
        is_any_scan = true;
      }
      at += 2 + (byte(at + 2) << 8 | byte(at + 3));
    }
  }
  return is_only_scan ? JpegEnd::kAfterSingleScan : JpegEnd::kTruncated;
}

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

const std::set<std::string> kSupportedExtensions = {
    ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".webp"};
const std::set<std::string> kUnsupportedExtensions = {
    ".arw",  ".avif", ".cr2", ".cr3", ".dng", ".exr", ".gif",
    ".heic", ".heif", ".jp2", ".jxl", ".nef", ".raf"};

// Images that calibrate and detect --overlay write to their output folders.
const std::set<std::string> kOutputImages = {
    "coverage.png", "example_after.png", "example_before.png",
    "uncertainty.png"};

void AddImagesInFolder(const std::string& folder, FoundImages* found) {
  std::set<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    paths.insert(entry.path().string());
  if (error)
    throw InputError(
        fmt::format("{}: cannot be read ({})", folder, error.message()));
  const size_t num_before = found->paths.size();
  for (const std::string& path : paths) {
    const std::string extension = LowerExtension(path);
    if (kOutputImages.count(fs::path(path).filename().string()))
      found->left_out.push_back(
          {path, "an output image of raygrid, not a camera image"});
    else if (kSupportedExtensions.count(extension))
      found->paths.push_back(path);
    else if (kUnsupportedExtensions.count(extension))
      found->left_out.push_back(
          {path, "unsupported image format; convert it to PNG"});
  }
  if (found->paths.size() == num_before)
    throw InputError(folder + ": contains no images (png, jpg, tif, bmp, pgm)");
}

// Sets the orientation tag to upright, because libtiff otherwise rotates
// images.
std::string RemoveOrientation(std::string bytes, const ImageHeader& header) {
  const bool is_little_endian = bytes[0] == 'I';
  const size_t last = header.orientation_bytes - 1;
  for (size_t i = 0; i <= last; ++i)
    bytes[header.orientation_at + i] = i == (is_little_endian ? 0 : last);
  return bytes;
}

// Decodes an image without applying its orientation; throws if it is corrupt.
cv::Mat Decode(const std::string& name, const std::string& file,
               PixelConversion conversion) {
  const ImageHeader header = ParseImageHeader(name, file);
  std::string changed;
  if (header.orientation > 1 && header.orientation_bytes > 0)
    changed = RemoveOrientation(file, header);
  const bool is_jpeg = file.compare(0, 2, "\xff\xd8") == 0;
  const JpegEnd end = is_jpeg ? FindJpegEnd(file) : JpegEnd::kWithEndMarker;
  // With an end marker, the decoder reports missing scan data instead of the
  // missing marker.
  if (end == JpegEnd::kAfterSingleScan) changed = file + "\xff\xd9";
  const std::string& bytes = changed.empty() ? file : changed;
  cv::Mat decoded;
  if (end != JpegEnd::kTruncated) decoded = DecodeImage(bytes, conversion);
  if (decoded.empty())
    throw InputError(name +
                     ": not an image, corrupt, or of an unsupported kind "
                     "(CMYK, PBM, compressed BMP); convert it to PNG, or "
                     "remove it");
  return decoded;
}

// Returns the full-scale value of a camera by the maximum of its 16-bit values.
double GetFullScale(double brightest) {
  for (const int bits : {8, 10, 12, 14})
    if (brightest < 1 << bits) return (1 << bits) - 1;
  return 65535;
}

double GetFullScale(const cv::Mat& image) {
  if (image.depth() == CV_8U) return 255;
  double brightest = 0;
  cv::minMaxIdx(image, nullptr, &brightest);
  return GetFullScale(brightest);
}

// Decodes an image with 8 or 16 bits per channel; throws for others.
cv::Mat DecodeIntegers(const std::string& name, const std::string& bytes,
                       PixelConversion conversion) {
  const cv::Mat decoded = Decode(name, bytes, conversion);
  if (decoded.depth() != CV_8U && decoded.depth() != CV_16U)
    throw InputError(
        name +
        ": unsupported pixel depth, expected 8 or 16 bits; convert it to PNG");
  return decoded;
}

Image ReadWithDecoder(PixelConversion conversion, const std::string& path) {
  const std::string bytes = ReadImageFile(path);
  const cv::Mat decoded = DecodeIntegers(path, bytes, conversion);
  Image image;
  image.size = {decoded.cols, decoded.rows};
  image.channels = decoded.channels();
  image.sample_bytes = static_cast<int>(decoded.elemSize1());
  image.pixels.assign(decoded.datastart, decoded.dataend);
  image.is_turned = ParseImageHeader(path, bytes).orientation != 1;
  return image;
}

}  // namespace

std::string ReadImageFile(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw InputError(path + ": not a regular file");
  const uintmax_t size = fs::file_size(path, error);
  if (!error && size > INT_MAX)
    throw InputError(path +
                     ": exceeds the limit of 2 GiB; reduce the image size");
  return ReadFile(path);
}

Image ReadImage(const std::string& path, bool grey) {
  return ReadWithDecoder(
      grey ? PixelConversion::kGrey : PixelConversion::kColor, path);
}

Image ReadImageAsStored(const std::string& path) {
  return ReadWithDecoder(PixelConversion::kNone, path);
}

Image ReadGreyAsStored(const std::string& path) {
  return ReadWithDecoder(PixelConversion::kGreyAnyDepth, path);
}

GreyLevels DecodeGreyLevels(const std::string& name, const std::string& bytes) {
  const cv::Mat decoded =
      DecodeIntegers(name, bytes, PixelConversion::kGreyAnyDepth);
  GreyLevels grey;
  grey.size = {decoded.cols, decoded.rows};
  grey.levels.resize(decoded.total());
  cv::Mat levels(decoded.size(), CV_32F, grey.levels.data());
  const double level_step = 255 / GetFullScale(decoded);
  decoded.convertTo(levels, CV_32F, level_step);
  grey.level_step = static_cast<float>(level_step);
  grey.was_mosaic = BalanceMosaic(&grey);
  return grey;
}

GreyLevels ReadGreyLevels(const std::string& path) {
  return DecodeGreyLevels(path, ReadImageFile(path));
}

std::string EncodePng(const Image& image) {
  const cv::Mat pixels(
      image.size.height, image.size.width,
      CV_MAKETYPE(image.sample_bytes == 1 ? CV_8U : CV_16U, image.channels),
      const_cast<uint8_t*>(image.pixels.data()));
  return EncodePng(pixels);
}

FoundImages FindImages(const std::vector<std::string>& paths) {
  FoundImages found;
  for (const std::string& path : paths) {
    std::error_code error;
    if (fs::is_directory(path, error))
      AddImagesInFolder(path, &found);
    else
      found.paths.push_back(path);
  }
  std::sort(found.paths.begin(), found.paths.end(),
            [](const std::string& a, const std::string& b) {
              return std::make_pair(fs::path(a).filename(), a) <
                     std::make_pair(fs::path(b).filename(), b);
            });
  return found;
}

std::string WarnAboutOrientation(const std::vector<std::string>& names) {
  if (names.empty()) return "";
  return fmt::format(
      "{}: EXIF orientation ignored; the image is used as stored, in sensor "
      "rows and columns",
      fmt::join(names, ", "));
}

}  // namespace raygrid
