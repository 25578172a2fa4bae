#include "stream_format.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "camera_error.h"
#include "rgb_rows.h"

namespace raygrid {
namespace {

StreamFormat Make(const char* name, uint32_t width, uint32_t height,
                  uint32_t stride = 0) {
  return MakeStreamFormat(*FindPixelFormat(name), width, height, stride);
}

TEST(StreamFormat, EveryFormatOfTheRuntimeHasAName) {
  std::set<rg_format> formats;
  std::set<std::string> names;
  for (const PixelFormatInfo& format : PixelFormats()) {
    formats.insert(format.format);
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
  }
  EXPECT_EQ(formats.size(), size_t{RG_NUM_FORMATS});
  EXPECT_EQ(FindPixelFormat("MJPEG"), nullptr);
}

// SRGGB10 is red, green in the first row; ARGB8888 blue, green, red, alpha.
TEST(StreamFormat, OrdersAreThoseOfTheNames) {
  for (const PixelFormatInfo& format : PixelFormats()) {
    std::string letters = format.name;
    letters = letters.substr(0, letters.find_first_of("0123456789"));
    if (format.model == ColourModel::kBayer)
      letters.erase(0, 1);
    else if (FindChannel(format.format, 0).component.num_channels > 1)
      std::reverse(letters.begin(), letters.end());
    else
      continue;
    const bool is_yuv = format.model == ColourModel::kYuv;
    for (size_t i = 0; i < 3; ++i)
      EXPECT_EQ(letters.find((is_yuv ? "YUV" : "RGB")[i]), format.order[i])
          << format.name;
  }
}

TEST(StreamFormat, SuggestsNamesForThoseOfOtherPrograms) {
  for (const auto& [other, name] :
       std::vector<std::pair<const char*, const char*>>{
           {"GREY", "R8"},
           {"GRAY8", "R8"},
           {"gray", "R8"},
           {"Y10", "R10"},
           {"GRAY16_LE", "R16"},
           {"YUY2", "YUYV"},
           {"I420", "YUV420"},
           {"yuv420p", "YUV420"},
           {"rgb24", "BGR888"},
           {"pgAA", "SGRBG10_CSI2P"},
           {"pGAA", "SGBRG10_CSI2P"}}) {
    EXPECT_EQ(FindPixelFormat(other), nullptr);
    EXPECT_EQ(DescribeOtherName(other), std::string("use ") + name);
  }
  for (const char* name : {"R8", "NV12", "MJPEG", "", "NV13"})
    EXPECT_EQ(DescribeOtherName(name), "") << name;
  try {
    RequirePixelFormat("NV13");
    FAIL();
  } catch (const CameraError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("NV13 is not supported; use one of R8, R10"),
              std::string::npos)
        << what;
  }
}

TEST(StreamFormat, PlanesFollowFromTheFirstStride) {
  const StreamFormat nv12 = Make("NV12", 64, 48, 80);
  EXPECT_EQ(nv12.num_planes, 2);
  EXPECT_EQ(nv12.planes[1].stride, 80u);
  EXPECT_EQ(nv12.planes[1].row_bytes, 64u);
  EXPECT_EQ(nv12.planes[1].rows, 24u);
  EXPECT_EQ(nv12.packed_size(), 64u * 72);

  const StreamFormat yuv420 = Make("YUV420", 64, 48, 80);
  EXPECT_EQ(yuv420.num_planes, 3);
  EXPECT_EQ(yuv420.planes[2].stride, 40u);
  EXPECT_EQ(yuv420.planes[2].row_bytes, 32u);
  EXPECT_EQ(yuv420.packed_size(), 64u * 72);

  const StreamFormat bayer = Make("SRGGB10_CSI2P", 64, 48);
  EXPECT_EQ(bayer.num_planes, 1);
  EXPECT_EQ(bayer.planes[0].row_bytes, 80u);
  EXPECT_EQ(bayer.planes[0].rows, 48u);
  EXPECT_EQ(Make("YUYV", 634, 478).planes[0].stride, 1268u);
}

TEST(StreamFormat, SizesAndStridesThatCannotBeAreRefused) {
  EXPECT_THROW(Make("YUYV", 63, 48), CameraError);
  EXPECT_THROW(Make("NV12", 64, 47), CameraError);
  EXPECT_THROW(Make("R10_CSI2P", 62, 48), CameraError);
  EXPECT_THROW(Make("R8", 0, 48), CameraError);
  EXPECT_THROW(Make("R8", 20000, 48), CameraError);
  EXPECT_THROW(Make("R8", 64, 48, 63), CameraError);
  EXPECT_THROW(Make("YUV420", 64, 48, 63), CameraError);
}

// A picture of 2 x 2 pixels of one colour.
std::vector<int> ColourOf(const char* name, std::vector<uint8_t> bytes,
                          bool is_full_range = false) {
  StreamFormat format = Make(name, 2, 2);
  format.is_full_range = is_full_range;
  EXPECT_EQ(format.packed_size(), bytes.size()) << name;
  uint8_t rgb[6];
  ReadRgbRow(format, MakePackedImage(format, bytes.data()), 1, rgb);
  return {rgb[3], rgb[4], rgb[5]};
}

std::vector<uint8_t> Repeat(std::vector<uint8_t> bytes, int times) {
  std::vector<uint8_t> result;
  for (int i = 0; i < times; ++i)
    result.insert(result.end(), bytes.begin(), bytes.end());
  return result;
}

TEST(PictureRows, ColoursAreWhereTheFormatHasThem) {
  const std::vector<int> colour = {10, 20, 30};
  EXPECT_EQ(ColourOf("RGB888", Repeat({30, 20, 10}, 4)), colour);
  EXPECT_EQ(ColourOf("BGR888", Repeat({10, 20, 30}, 4)), colour);
  EXPECT_EQ(ColourOf("XRGB8888", Repeat({30, 20, 10, 0}, 4)), colour);
  EXPECT_EQ(ColourOf("XBGR8888", Repeat({10, 20, 30, 0}, 4)), colour);
  EXPECT_EQ(ColourOf("RGBX8888", Repeat({0, 30, 20, 10}, 4)), colour);
  EXPECT_EQ(ColourOf("BGRX8888", Repeat({0, 10, 20, 30}, 4)), colour);
  // 1, 40 and 3 of 31, 63 and 31: 0x0d03, the low byte first.
  EXPECT_EQ(ColourOf("RGB565", Repeat({0x03, 0x0d}, 4)),
            (std::vector<int>{8, 162, 24}));
  EXPECT_EQ(ColourOf("RGB565", Repeat({0xff, 0xff}, 4)),
            (std::vector<int>{255, 255, 255}));
  EXPECT_EQ(ColourOf("SRGGB8", {10, 20, 20, 30}), colour);
  EXPECT_EQ(ColourOf("SGRBG8", {20, 10, 30, 20}), colour);
  EXPECT_EQ(ColourOf("SGBRG8", {20, 30, 10, 20}), colour);
  EXPECT_EQ(ColourOf("SBGGR8", {30, 20, 20, 10}), colour);
  EXPECT_EQ(ColourOf("SRGGB12", {160, 0, 64, 1, 64, 1, 224, 1}), colour);
  EXPECT_EQ(ColourOf("R8", {7, 7, 7, 7}), (std::vector<int>{7, 7, 7}));
  EXPECT_EQ(ColourOf("R10", {0, 2, 0, 2, 0, 2, 0, 2}),
            (std::vector<int>{128, 128, 128}));
}

TEST(PictureRows, RedIsRedInEveryOrderOfYuv) {
  // Red of BT.601.
  const uint8_t y = 81, u = 90, v = 240;
  const std::vector<std::vector<int>> pictures = {
      ColourOf("YUYV", Repeat({y, u, y, v}, 2)),
      ColourOf("YVYU", Repeat({y, v, y, u}, 2)),
      ColourOf("UYVY", Repeat({u, y, v, y}, 2)),
      ColourOf("VYUY", Repeat({v, y, u, y}, 2)),
      ColourOf("NV12", {y, y, y, y, u, v}),
      ColourOf("NV21", {y, y, y, y, v, u}),
      ColourOf("YUV420", {y, y, y, y, u, v}),
      ColourOf("YVU420", {y, y, y, y, v, u}),
      ColourOf("XVUY8888", Repeat({y, u, v, 0}, 4))};
  for (const std::vector<int>& rgb : pictures) {
    EXPECT_GE(rgb[0], 253);
    EXPECT_LE(rgb[1], 2);
    EXPECT_LE(rgb[2], 2);
  }
}

TEST(PictureRows, BlackAndWhiteAreThoseOfTheRange) {
  const std::vector<int> black = {0, 0, 0}, white = {255, 255, 255};
  const auto grey = [](uint8_t y) {
    return std::vector<uint8_t>{y, y, y, y, 128, 128};
  };
  EXPECT_EQ(ColourOf("NV12", grey(16)), black);
  EXPECT_EQ(ColourOf("NV12", grey(235)), white);
  EXPECT_EQ(ColourOf("NV12", grey(0), true), black);
  EXPECT_EQ(ColourOf("NV12", grey(16), true), (std::vector<int>{16, 16, 16}));
  EXPECT_EQ(ColourOf("NV12", grey(255), true), white);
  // Red of BT.601, as JPEG has it.
  const std::vector<int> red =
      ColourOf("YUV420", {76, 76, 76, 76, 85, 255}, true);
  EXPECT_GE(red[0], 253);
  EXPECT_LE(red[1] + red[2], 4);
}

TEST(StreamFormat, OnlyTheBorderOfYuvHasARange) {
  for (const PixelFormatInfo& pixel_format : PixelFormats()) {
    const char* const name = pixel_format.name;
    StreamFormat format = Make(name, 8, 8);
    rg_target of_video = {}, full = {};
    SetBlackBorder(format, &of_video);
    format.is_full_range = true;
    SetBlackBorder(format, &full);
    const bool is_yuv = format.pixel_format->model == ColourModel::kYuv;
    EXPECT_EQ(of_video.border_values[0] - full.border_values[0],
              is_yuv ? 16 : 0)
        << name;
    for (int c = 1; c < 4; ++c)
      EXPECT_EQ(of_video.border_values[c], full.border_values[c]) << name;
    if (is_yuv) {
      EXPECT_EQ(full.border_values[0], 0) << name;
    }
  }
}

}  // namespace
}  // namespace raygrid
