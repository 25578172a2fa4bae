#ifndef RAYGRID_DATASET_IMAGE_HEADER_H
#define RAYGRID_DATASET_IMAGE_HEADER_H

#include <cstddef>
#include <cstdint>
#include <string>

#include "camera/area.h"

namespace raygrid {

/// Properties of an image from its file header.
struct ImageHeader {
  ImageSize size;
  /// EXIF orientation: 1 is unrotated, 2 to 8 are rotated or mirrored.
  int orientation = 1;
  /// TIFF: the offset of the orientation's value in the file, and its size.
  size_t orientation_at = 0, orientation_bytes = 0;
  /// PNG, JPEG, WebP: the offset and size of the EXIF data, which have TIFF's
  /// structure; 0 if absent.
  size_t exif_at = 0, exif_bytes = 0;
};

/// Parses the header of a PNG, JPEG, TIFF, BMP, PNM or WebP file. Throws
/// InputError for other formats, corrupt files, and refused sizes.
ImageHeader ParseImageHeader(const std::string& name, const std::string& bytes);

/// Larger images are rejected unless AllowHugeImages() was called: they need
/// minutes and gigabytes, and most are not photographs.
constexpr int kMaxSidePx = 16384;
/// The limits with --allow-huge-images: pixel indices fit into 31 bits.
constexpr int kMaxHugeSidePx = 65535;
constexpr int64_t kMaxHugePixels = int64_t{1} << 30;

/// Allows huge images until the program exits.
void AllowHugeImages();

/// Returns why an image of this size is rejected; empty if it is accepted.
std::string DescribeSizeLimit(uint64_t width, uint64_t height);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_HEADER_H
