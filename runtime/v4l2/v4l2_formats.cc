#include "v4l2_formats.h"

#include <cstring>

namespace raygrid {
namespace {

constexpr uint32_t Code(const char (&letters)[5]) {
  return static_cast<uint32_t>(letters[0]) |
         static_cast<uint32_t>(letters[1]) << 8 |
         static_cast<uint32_t>(letters[2]) << 16 |
         static_cast<uint32_t>(letters[3]) << 24;
}

}  // namespace

const PixelFormatInfo* FindV4l2Format(uint32_t code) {
  char letters[4];
  for (int i = 0; i < 4; ++i) letters[i] = static_cast<char>(code >> 8 * i);
  for (const PixelFormatInfo& format : PixelFormats())
    for (const char* name : {format.v4l2, format.v4l2_separate})
      if (name && std::memcmp(name, letters, 4) == 0) return &format;
  return nullptr;
}

bool IsJpegFormat(uint32_t code) {
  return code == Code("MJPG") || code == Code("JPEG");
}

std::string V4l2FormatName(uint32_t code) {
  if (IsJpegFormat(code)) return "MJPEG";
  if (const PixelFormatInfo* const info = FindV4l2Format(code))
    return info->name;
  std::string name;
  for (int i = 0; i < 4; ++i) {
    const char letter = static_cast<char>(code >> 8 * i & 0x7f);
    if (letter > ' ' && letter < 0x7f) name += letter;
  }
  return name;
}

}  // namespace raygrid
