#ifndef RAYGRID_DATASET_IMAGE_FILES_H
#define RAYGRID_DATASET_IMAGE_FILES_H

#include <cstdint>
#include <string>
#include <vector>

#include "camera/area.h"

namespace raygrid {

/// 8-bit image; rows without padding, channels interleaved (1: grey, 3: BGR).
struct Image {
  ImageSize size;
  int channels = 1;
  std::vector<uint8_t> pixels;

  size_t stride() const { return static_cast<size_t>(size.width) * channels; }
};

/// Reads PNG, JPEG, TIFF, BMP, PGM and what else OpenCV reads; without the
/// camera's rotation tag. Throws InputError.
Image ReadImage(const std::string& path, bool grey);

/// A photograph in shades of grey, as finely as the file has them.
struct GreyLevels {
  ImageSize size;
  std::vector<float> levels;  ///< row by row; 0 to 255, whatever the file has
};

/// Reads files of 8 or 16 bits, grey or in colour. Cameras put values of 10, 12
/// or 14 bits into 16: the brightest pixel tells which bits are in use. Throws
/// InputError.
GreyLevels ReadGreyLevels(const std::string& path);
/// The same from a file's bytes; name is used in errors.
GreyLevels DecodeGreyLevels(const std::string& name, const std::string& bytes);

std::string EncodePng(const Image& image);

/// The image files among paths, and in those that are folders, in the order of
/// their names, whatever the order of paths. Throws InputError if a folder has
/// none.
std::vector<std::string> FindImages(const std::vector<std::string>& paths);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_FILES_H
