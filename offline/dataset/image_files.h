#ifndef RAYGRID_DATASET_IMAGE_FILES_H
#define RAYGRID_DATASET_IMAGE_FILES_H

#include <cstdint>
#include <string>
#include <vector>

#include "camera/area.h"

namespace raygrid {

/// Rows without padding, channels interleaved (1: grey, 3: BGR, 4: BGRA).
struct Image {
  ImageSize size;
  int channels = 1;
  int sample_bytes = 1;  ///< bytes per channel; 2: 16 bits, native endian
  std::vector<uint8_t> pixels;
  bool is_turned = false;  ///< the file requests rotation (EXIF)

  size_t stride() const {
    return static_cast<size_t>(size.width) * channels * sample_bytes;
  }
};

/// Reads a file's bytes. Throws InputError: not a regular file, 2 GiB or more.
std::string ReadImageFile(const std::string& path);

/// Reads PNG, JPEG, TIFF, BMP, PNM and WebP as 8 bits, grey or BGR. Orientation
/// tags are ignored: pixels are in the sensor's rows and columns, to which the
/// calibration refers. Throws InputError, also for images larger than
/// ParseImageHeader() allows.
Image ReadImage(const std::string& path, bool grey);

/// Reads an image with the channels and depth (8 or 16 bits) of its file.
Image ReadImageAsStored(const std::string& path);
/// Reads an image as grey, with the depth (8 or 16 bits) of its file.
Image ReadGreyAsStored(const std::string& path);

/// A grey image with the resolution of the intensities in its file.
struct GreyLevels {
  ImageSize size;
  std::vector<float> levels;  ///< row by row; 0 to 255 for any depth
  float level_step = 1;       ///< between successive values of the file
  bool was_mosaic = false;    ///< see BalanceMosaic()
};

/// Reads files of 8 or 16 bits, grey or colour. Cameras store 10, 12 or 14 bits
/// in 16: the bits in use are inferred from the brightest pixel. Raw colour
/// mosaics are balanced. Throws InputError.
GreyLevels ReadGreyLevels(const std::string& path);
/// Decodes grey levels from a file's bytes; name is used in errors.
GreyLevels DecodeGreyLevels(const std::string& name, const std::string& bytes);

/// Encodes an image as PNG, with its channels and depth.
std::string EncodePng(const Image& image);

/// A skipped file, and the reason.
struct SkippedImage {
  std::string path, reason;
};

struct FoundImages {
  std::vector<std::string> paths;
  /// Skipped files in folders: pictures written by raygrid, and unsupported
  /// formats.
  std::vector<SkippedImage> left_out;
};

/// Lists the image files among paths and in folders among them, sorted by name,
/// independently of the order of paths. Throws InputError if a folder has none.
FoundImages FindImages(const std::vector<std::string>& paths);

/// Formats the warning about images whose files request rotation (EXIF); empty
/// if there are none.
std::string WarnAboutOrientation(const std::vector<std::string>& names);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_FILES_H
