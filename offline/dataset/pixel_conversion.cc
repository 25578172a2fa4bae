#include "dataset/pixel_conversion.h"

#include <utility>

namespace raygrid {
namespace {

template <typename From, typename To>
void ConvertRow(const From* from, int from_channels, const GreyWeights& weights,
                int width, To* to, int to_channels) {
  constexpr int kShift = 8 * (sizeof(From) - sizeof(To));
  for (int x = 0; x < width; ++x) {
    const From* pixel = from + x * from_channels;
    if (to_channels == 1 && from_channels > 1) {
      const int64_t sum = int64_t(weights.blue) * (pixel[0] >> kShift) +
                          weights.green * (pixel[1] >> kShift) +
                          weights.red * (pixel[2] >> kShift);
      to[x] =
          static_cast<To>((sum + (1 << (weights.bits - 1))) >> weights.bits);
      continue;
    }
    for (int c = 0; c < to_channels; ++c)
      to[x * to_channels + c] =
          static_cast<To>(pixel[from_channels == 1 ? 0 : c] >> kShift);
  }
}

}  // namespace

bool Keeps16Bits(PixelConversion conversion) {
  return conversion == PixelConversion::kNone ||
         conversion == PixelConversion::kGreyAnyDepth;
}

int TypeFor(PixelConversion conversion, int channels, int bits) {
  if (conversion == PixelConversion::kColor)
    channels = 3;
  else if (conversion != PixelConversion::kNone)
    channels = 1;
  const bool is_wide = bits == 16 && Keeps16Bits(conversion);
  return CV_MAKETYPE(is_wide ? CV_16U : CV_8U, channels);
}

cv::Mat Converted(const cv::Mat& stored, PixelConversion conversion,
                  const GreyWeights& weights) {
  const int bits = stored.depth() == CV_16U ? 16 : 8;
  const int type = TypeFor(conversion, stored.channels(), bits);
  if (type == stored.type()) return stored;
  cv::Mat result(stored.size(), type);
  for (int y = 0; y < stored.rows; ++y) {
    const int from = stored.channels(), to = result.channels();
    if (bits == 8)
      ConvertRow(stored.ptr(y), from, weights, stored.cols, result.ptr(y), to);
    else if (result.depth() == CV_8U)
      ConvertRow(stored.ptr<uint16_t>(y), from, weights, stored.cols,
                 result.ptr(y), to);
    else
      ConvertRow(stored.ptr<uint16_t>(y), from, weights, stored.cols,
                 result.ptr<uint16_t>(y), to);
  }
  return result;
}

void SwapRedAndBlue(cv::Mat* pixels) {
  const int channels = pixels->channels();
  for (int y = 0; y < pixels->rows; ++y)
    for (int x = 0; x < pixels->cols; ++x) {
      if (pixels->depth() == CV_16U) {
        uint16_t* pixel = pixels->ptr<uint16_t>(y) + x * channels;
        std::swap(pixel[0], pixel[2]);
      } else {
        uint8_t* pixel = pixels->ptr(y) + x * channels;
        std::swap(pixel[0], pixel[2]);
      }
    }
}

}  // namespace raygrid
