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
  int sample_bytes =
      1;  ///< of each channel; 2: 16 bits as processors have them
  std::vector<uint8_t> pixels;
  bool is_turned = false;  ///< its file asks to be shown turned

  size_t stride() const {
    return static_cast<size_t>(size.width) * channels * sample_bytes;
  }
};

/// An image file's bytes. Throws InputError: no regular file, 2 GiB or more.
std::string ReadImageFile(const std::string& path);

/// Reads PNG, JPEG, TIFF, BMP, PGM and its kin, and WebP, as 8 bits, grey or
/// BGR. Pixels are as stored, whatever a tag says of showing them turned: those
/// are the sensor's rows and columns, which the lens was mounted to. Throws
/// InputError, for larger images than ParseImageHeader() allows too.
Image ReadImage(const std::string& path, bool grey);

/// A photograph with the channels and the depth (8 or 16 bits) of its file.
Image ReadImageAsStored(const std::string& path);
/// A photograph in shades of grey, with the depth (8 or 16 bits) of its file.
Image ReadGreyAsStored(const std::string& path);

/// A photograph in shades of grey, as finely as the file has them.
struct GreyLevels {
  ImageSize size;
  std::vector<float> levels;  ///< row by row; 0 to 255, whatever the file has
  float level_step = 1;       ///< between the file's values
  bool was_mosaic = false;    ///< see BalanceMosaic()
};

/// Reads files of 8 or 16 bits, grey or in colour. Cameras put values of 10, 12
/// or 14 bits into 16: the brightest pixel tells which bits are in use. Raw
/// colour mosaics are balanced. Throws InputError.
GreyLevels ReadGreyLevels(const std::string& path);
/// Reads grey levels from a file's bytes; name is used in errors.
GreyLevels DecodeGreyLevels(const std::string& name, const std::string& bytes);

/// The PNG file of an image, with the image's channels and depth.
std::string EncodePng(const Image& image);

/// A file that is not used, and why.
struct SkippedImage {
  std::string path, reason;
};

struct FoundImages {
  std::vector<std::string> paths;
  /// The files in folders that are left out: pictures that raygrid wrote, and
  /// kinds that are not read.
  std::vector<SkippedImage> left_out;
};

/// The image files among paths, and in those that are folders, in the order of
/// their names, whatever the order of paths. Throws InputError if a folder has
/// none.
FoundImages FindImages(const std::vector<std::string>& paths);

/// The remark on images whose files ask to be shown turned (EXIF); empty for
/// none.
std::string RemarkOnTurned(const std::vector<std::string>& names);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_FILES_H
