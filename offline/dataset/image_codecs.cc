#include "dataset/image_codecs.h"

#include <webp/decode.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "dataset/pixel_conversion.h"

namespace raygrid {
namespace {

// ---- WebP

cv::Mat DecodeWebp(const std::string& bytes, PixelConversion conversion) {
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK)
    return {};
  const int channels =
      features.has_alpha && conversion == PixelConversion::kNone ? 4 : 3;
  cv::Mat pixels(features.height, features.width, CV_MAKETYPE(CV_8U, channels));
  const size_t size = pixels.total() * pixels.elemSize();
  const int stride = static_cast<int>(pixels.step);
  const uint8_t* done =
      channels == 4
          ? WebPDecodeBGRAInto(data, bytes.size(), pixels.data, size, stride)
          : WebPDecodeBGRInto(data, bytes.size(), pixels.data, size, stride);
  return done ? Converted(pixels, conversion, kWebpGreyWeights) : cv::Mat();
}

// ---- PGM and PPM

// Reads the next number of a header or of text pixels; -1 if there is none.
int NextNumber(const std::string& bytes, size_t* position) {
  size_t& at = *position;
  while (at < bytes.size() &&
         (std::isspace(uint8_t(bytes[at])) || bytes[at] == '#'))
    at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size())
                          : at + 1;
  int value = -1;
  for (; at < bytes.size() && std::isdigit(uint8_t(bytes[at])); ++at) {
    value = std::max(value, 0) * 10 + (bytes[at] - '0');
    if (value > 1 << 20) return -1;
  }
  return value;
}

cv::Mat DecodePnm(const std::string& bytes, PixelConversion conversion) {
  const bool is_text = bytes[1] < '4';
  const int channels = bytes[1] == '3' || bytes[1] == '6' ? 3 : 1;
  size_t at = 2;
  const int columns = NextNumber(bytes, &at), rows = NextNumber(bytes, &at);
  const int most = NextNumber(bytes, &at);
  if (columns <= 0 || rows <= 0 || most <= 0 || most > 65535) return {};
  const bool is_16_bit = most > 255;
  cv::Mat pixels(rows, columns,
                 CV_MAKETYPE(is_16_bit ? CV_16U : CV_8U, channels));
  const size_t count = pixels.total() * channels;
  ++at;  // one white-space character ends the header
  if (!is_text &&
      bytes.size() - std::min(at, bytes.size()) < count * (is_16_bit ? 2 : 1))
    return {};
  for (size_t i = 0; i < count; ++i) {
    int value = 0;
    if (is_text) {
      value = NextNumber(bytes, &at);
      if (value < 0 || value > most) return {};
    } else {
      value = uint8_t(bytes[at++]);
      if (is_16_bit) value = value << 8 | uint8_t(bytes[at++]);
    }
    if (is_16_bit)
      reinterpret_cast<uint16_t*>(pixels.data)[i] =
          static_cast<uint16_t>(value);
    else
      pixels.data[i] = static_cast<uint8_t>(value);
  }
  if (channels > 1) SwapRedAndBlue(&pixels);
  return Converted(pixels, conversion);
}

// ---- BMP, only the common variants without compression

uint32_t ReadLittleEndian(const std::string& bytes, size_t at, int count) {
  uint32_t value = 0;
  for (int i = count - 1; i >= 0; --i)
    value = value << 8 | uint8_t(bytes[at + i]);
  return value;
}

cv::Mat DecodeBmp(const std::string& bytes, PixelConversion conversion) {
  constexpr size_t kHeaders = 54;
  if (bytes.size() < kHeaders || ReadLittleEndian(bytes, 14, 4) < 40) return {};
  const size_t begin = ReadLittleEndian(bytes, 10, 4),
               palette = 14 + ReadLittleEndian(bytes, 14, 4);
  const int columns = static_cast<int32_t>(ReadLittleEndian(bytes, 18, 4));
  const int64_t signed_rows =
      static_cast<int32_t>(ReadLittleEndian(bytes, 22, 4));
  const int64_t rows = std::abs(signed_rows);
  const uint32_t bits = ReadLittleEndian(bytes, 28, 2),
                 compression = ReadLittleEndian(bytes, 30, 4);
  if (columns <= 0 || rows == 0 || (bits != 8 && bits != 24 && bits != 32) ||
      compression != 0)
    return {};
  const size_t stride = (size_t(columns) * bits / 8 + 3) / 4 * 4;
  if (begin > bytes.size() || bytes.size() - begin < stride * rows) return {};
  size_t num_colors = ReadLittleEndian(bytes, 46, 4);
  if (num_colors == 0) num_colors = 256;
  if (bits == 8 &&
      (num_colors > 256 || palette > begin || begin - palette < 4 * num_colors))
    return {};
  bool is_grey = bits == 8;
  for (size_t i = 0; is_grey && i < num_colors; ++i) {
    const char* color = bytes.data() + palette + 4 * i;
    is_grey = color[0] == color[1] && color[1] == color[2];
  }
  cv::Mat pixels(static_cast<int>(rows), columns, is_grey ? CV_8UC1 : CV_8UC3);
  for (int y = 0; y < rows; ++y) {
    const char* from =
        bytes.data() + begin + stride * (signed_rows > 0 ? rows - 1 - y : y);
    for (int x = 0; x < columns; ++x) {
      const char* color = from + size_t(x) * bits / 8;
      if (bits == 8) {
        const size_t index = uint8_t(*color);
        if (index >= num_colors) return {};
        color = bytes.data() + palette + 4 * index;
      }
      std::memcpy(pixels.ptr(y) + x * pixels.channels(), color,
                  pixels.channels());
    }
  }
  return Converted(pixels, conversion);
}

bool BeginsWith(const std::string& bytes, const std::string& magic,
                size_t at = 0) {
  return bytes.compare(at, magic.size(), magic) == 0;
}

}  // namespace

cv::Mat DecodeImage(const std::string& bytes, PixelConversion conversion) {
  if (bytes.size() < 12) return {};
  if (BeginsWith(bytes, "\xff\xd8\xff")) return DecodeJpeg(bytes, conversion);
  if (BeginsWith(bytes, "\x89PNG")) return DecodePng(bytes, conversion);
  if (BeginsWith(bytes, {'I', 'I', '*', '\0'}) ||
      BeginsWith(bytes, {'M', 'M', '\0', '*'}))
    return DecodeTiff(bytes, conversion);
  if (BeginsWith(bytes, "RIFF") && BeginsWith(bytes, "WEBP", 8))
    return DecodeWebp(bytes, conversion);
  if (bytes[0] == 'P' && std::strchr("2356", bytes[1]) && bytes[1])
    return DecodePnm(bytes, conversion);
  if (BeginsWith(bytes, "BM")) return DecodeBmp(bytes, conversion);
  return {};
}

}  // namespace raygrid
