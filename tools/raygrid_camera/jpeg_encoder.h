#ifndef RAYGRID_CAMERA_JPEG_ENCODER_H
#define RAYGRID_CAMERA_JPEG_ENCODER_H

#include <cstdint>
#include <vector>

#include "stream_format.h"

namespace raygrid {

/// Encodes frames as JPEG, in memory that is allocated once.
class JpegEncoder {
 public:
  explicit JpegEncoder(const StreamFormat& format);

  /// Returns the size of the JPEG in bytes(); 0 if it exceeds the buffer, or
  /// memory is exhausted.
  size_t Encode(const rg_image& image);
  const uint8_t* bytes() const { return bytes_.data(); }
  size_t max_size() const { return bytes_.size(); }

 private:
  const StreamFormat format_;
  std::vector<uint8_t> row_, bytes_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_JPEG_ENCODER_H
