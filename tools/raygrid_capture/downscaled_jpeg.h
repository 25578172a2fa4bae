#ifndef RAYGRID_CAPTURE_DOWNSCALED_JPEG_H
#define RAYGRID_CAPTURE_DOWNSCALED_JPEG_H

#include <cstdint>
#include <memory>
#include <vector>

#include "jpeg_encoder.h"
#include "stream_format.h"

namespace raygrid {

/// Encodes frames as smaller JPEGs: each pixel is the mean of a square. Memory
/// is reused for frames of equal size.
class DownscaledJpegEncoder {
 public:
  /// Returns the JPEG; empty on failure.
  /// max_side  maximum pixels of the longer side
  const std::vector<uint8_t>& Encode(const StreamFormat& format,
                                     const rg_image& image, int max_side);

 private:
  void Average(const StreamFormat& format, const rg_image& image, int side);

  int width_ = 0, height_ = 0;  // size of the smaller picture
  std::vector<uint8_t> row_, rgb_, jpeg_;
  std::vector<uint32_t> sums_;
  std::unique_ptr<JpegEncoder> encoder_;
};

/// Returns the format of 8-bit grey. Throws CameraError if the size is invalid.
StreamFormat MakeGreyFormat(int width, int height);
rg_image MakeGreyImage(const StreamFormat& format, const uint8_t* grey,
                       size_t row_bytes);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_DOWNSCALED_JPEG_H
