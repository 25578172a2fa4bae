#ifndef RAYGRID_CAPTURE_SMALLER_PICTURE_H
#define RAYGRID_CAPTURE_SMALLER_PICTURE_H

#include <cstdint>
#include <memory>
#include <vector>

#include "jpeg_encoder.h"
#include "stream_format.h"

namespace raygrid {

/// Frames as smaller JPEGs: each pixel is the mean of a square of the frame's.
/// Memory is kept for the next frame of the size.
class SmallerPicture {
 public:
  /// max_side  the longer side has at most so many pixels
  /// Bytes of the JPEG; empty where it cannot be made.
  const std::vector<uint8_t>& Encode(const StreamFormat& format,
                                     const rg_image& image, int max_side);

 private:
  void Average(const StreamFormat& format, const rg_image& image, int side);

  int width_ = 0, height_ = 0;  // of the smaller picture
  std::vector<uint8_t> row_, rgb_, jpeg_;
  std::vector<uint32_t> sums_;
  std::unique_ptr<JpegEncoder> encoder_;
};

/// 8 bits of grey. Throws CameraError for a size that no frame has.
StreamFormat MakeGreyFormat(int width, int height);
rg_image MakeGreyImage(const StreamFormat& format, const uint8_t* grey,
                       size_t row_bytes);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_SMALLER_PICTURE_H
