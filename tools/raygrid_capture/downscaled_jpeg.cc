#include "downscaled_jpeg.h"

#include <algorithm>

#include "rgb_rows.h"

namespace raygrid {
namespace {

// Three bytes per pixel: red, green, blue.
StreamFormat MakeRgbFormat(int width, int height) {
  return MakeStreamFormat(*FindPixelFormat("BGR888"),
                          static_cast<uint32_t>(width),
                          static_cast<uint32_t>(height), 0);
}

}  // namespace

void DownscaledJpegEncoder::Average(const StreamFormat& format,
                                    const rg_image& image, int side) {
  row_.resize(size_t{3} * format.width);
  sums_.resize(size_t{3} * width_);
  rgb_.resize(sums_.size() * height_);
  uint8_t* to = rgb_.data();
  const uint32_t area = static_cast<uint32_t>(side * side);
  for (int y = 0; y < height_; ++y) {
    std::fill(sums_.begin(), sums_.end(), area / 2);
    for (int k = 0; k < side; ++k) {
      ReadRgbRow(format, image, static_cast<uint32_t>(y * side + k),
                 row_.data());
      const uint8_t* from = row_.data();
      for (size_t x = 0; x < sums_.size(); x += 3)
        for (int i = 0; i < side; ++i, from += 3)
          for (size_t c = 0; c < 3; ++c) sums_[x + c] += from[c];
    }
    for (const uint32_t sum : sums_) *to++ = static_cast<uint8_t>(sum / area);
  }
}

const std::vector<uint8_t>& DownscaledJpegEncoder::Encode(
    const StreamFormat& format, const rg_image& image, int max_side) {
  const int longer = std::max(format.width, format.height);
  const int side = std::min((longer + max_side - 1) / max_side,
                            int{std::min(format.width, format.height)});
  const int width = format.width / side, height = format.height / side;
  if (!encoder_ || width != width_ || height != height_) {
    width_ = width;
    height_ = height;
    encoder_ = std::make_unique<JpegEncoder>(MakeRgbFormat(width, height));
  }
  Average(format, image, side);
  const StreamFormat smaller = MakeRgbFormat(width, height);
  const size_t size = encoder_->Encode(MakePackedImage(smaller, rgb_.data()));
  jpeg_.assign(encoder_->bytes(), encoder_->bytes() + size);
  return jpeg_;
}

StreamFormat MakeGreyFormat(int width, int height) {
  return MakeStreamFormat(*FindPixelFormat("R8"),
                          static_cast<uint32_t>(std::max(width, 0)),
                          static_cast<uint32_t>(std::max(height, 0)), 0);
}

rg_image MakeGreyImage(const StreamFormat& format, const uint8_t* grey,
                       size_t row_bytes) {
  rg_image image = MakePackedImage(format, grey);
  image.planes[0].stride = static_cast<uint32_t>(row_bytes);
  return image;
}

}  // namespace raygrid
