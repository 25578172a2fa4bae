#include "v4l2_formats.h"

namespace raygrid {
namespace {

constexpr uint32_t Code(const char (&letters)[5]) {
  return static_cast<uint32_t>(letters[0]) |
         static_cast<uint32_t>(letters[1]) << 8 |
         static_cast<uint32_t>(letters[2]) << 16 |
         static_cast<uint32_t>(letters[3]) << 24;
}

struct NamedCode {
  uint32_t code;
  const char* name;  // libcamera's
};

// Formats with an M have planes in memories of their own.
constexpr NamedCode kCodes[] = {
    {Code("GREY"), "R8"},
    {Code("Y10 "), "R10"},
    {Code("Y12 "), "R12"},
    {Code("Y14 "), "R14"},
    {Code("Y16 "), "R16"},
    {Code("Y10P"), "R10_CSI2P"},
    {Code("Y12P"), "R12_CSI2P"},
    {Code("BGR3"), "RGB888"},
    {Code("RGB3"), "BGR888"},
    {Code("XR24"), "XRGB8888"},
    {Code("AR24"), "ARGB8888"},
    {Code("XB24"), "XBGR8888"},
    {Code("AB24"), "ABGR8888"},
    {Code("RX24"), "RGBX8888"},
    {Code("RA24"), "RGBA8888"},
    {Code("BX24"), "BGRX8888"},
    {Code("BA24"), "BGRA8888"},
    {Code("YUVX"), "XVUY8888"},
    {Code("YUVA"), "AVUY8888"},
    {Code("RGBP"), "RGB565"},
    {Code("YUYV"), "YUYV"},
    {Code("YVYU"), "YVYU"},
    {Code("UYVY"), "UYVY"},
    {Code("VYUY"), "VYUY"},
    {Code("NV12"), "NV12"},
    {Code("NM12"), "NV12"},
    {Code("NV21"), "NV21"},
    {Code("NM21"), "NV21"},
    {Code("YU12"), "YUV420"},
    {Code("YM12"), "YUV420"},
    {Code("YV12"), "YVU420"},
    {Code("YM21"), "YVU420"},
    {Code("RGGB"), "SRGGB8"},
    {Code("GRBG"), "SGRBG8"},
    {Code("GBRG"), "SGBRG8"},
    {Code("BA81"), "SBGGR8"},
    {Code("RG10"), "SRGGB10"},
    {Code("BA10"), "SGRBG10"},
    {Code("GB10"), "SGBRG10"},
    {Code("BG10"), "SBGGR10"},
    {Code("RG12"), "SRGGB12"},
    {Code("BA12"), "SGRBG12"},
    {Code("GB12"), "SGBRG12"},
    {Code("BG12"), "SBGGR12"},
    {Code("RG14"), "SRGGB14"},
    {Code("GR14"), "SGRBG14"},
    {Code("GB14"), "SGBRG14"},
    {Code("BG14"), "SBGGR14"},
    {Code("RG16"), "SRGGB16"},
    {Code("GR16"), "SGRBG16"},
    {Code("GB16"), "SGBRG16"},
    {Code("BYR2"), "SBGGR16"},
    {Code("pRAA"), "SRGGB10_CSI2P"},
    {Code("pgAA"), "SGRBG10_CSI2P"},
    {Code("pGAA"), "SGBRG10_CSI2P"},
    {Code("pBAA"), "SBGGR10_CSI2P"},
    {Code("pRCC"), "SRGGB12_CSI2P"},
    {Code("pgCC"), "SGRBG12_CSI2P"},
    {Code("pGCC"), "SGBRG12_CSI2P"},
    {Code("pBCC"), "SBGGR12_CSI2P"},
};

}  // namespace

const PixelFormatInfo* FindV4l2Format(uint32_t code) {
  for (const NamedCode& named : kCodes)
    if (named.code == code) return FindPixelFormat(named.name);
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
