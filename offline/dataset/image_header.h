#ifndef RAYGRID_DATASET_IMAGE_HEADER_H
#define RAYGRID_DATASET_IMAGE_HEADER_H

#include <cstddef>
#include <cstdint>
#include <string>

#include "camera/area.h"

namespace raygrid {

/// The properties of an image that its file states before the pixels.
struct ImageHeader {
  ImageSize size;
  /// EXIF's number: 1 is to be shown as stored, 2 to 8 turned or mirrored.
  int orientation = 1;
  /// TIFF: where the orientation's number stands in the file, and its bytes.
  size_t orientation_at = 0, orientation_bytes = 0;
  /// PNG, JPEG, WebP: the first byte of EXIF's data, which are TIFF's, and how
  /// many there are; none: 0.
  size_t exif_at = 0, exif_bytes = 0;
};

/// Reads the header of a PNG, JPEG, TIFF, BMP, PNM (PGM and its kin) or WebP
/// file. Throws InputError: other kinds, damage, sizes that are refused.
ImageHeader ParseImageHeader(const std::string& name, const std::string& bytes);

/// Larger images are refused unless AllowHugeImages() was called: they take
/// minutes and gigabytes, and most are no photographs.
constexpr int kMaxSidePx = 16384;
/// The limits that --allow-huge-images allows: indices of pixels stay within 31
/// bits.
constexpr int kMaxHugeSidePx = 65535;
constexpr int64_t kMaxHugePixels = int64_t{1} << 30;

/// Allows huge images for the rest of the program.
void AllowHugeImages();

/// Why an image may not be of this size; empty if it may.
std::string WhySizeIsRefused(uint64_t width, uint64_t height);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_HEADER_H
