#include "dataset/image_codecs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support.h"

namespace raygrid {
namespace {

// The codecs read and write as OpenCV's do, to the bit.
constexpr std::array<PixelConversion, 4> kConversions = {
    PixelConversion::kGrey, PixelConversion::kColor,
    PixelConversion::kGreyAnyDepth, PixelConversion::kNone};

// A smooth picture with noise, of odd width.
cv::Mat Picture(int type) {
  cv::Mat picture(37, 51, type);
  cv::RNG noise(7);
  const double most = CV_MAT_DEPTH(type) == CV_8U ? 255 : 65535;
  const int channels = picture.channels();
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      for (int c = 0; c < channels; ++c) {
        const double value =
            most * (0.5 + 0.4 * std::sin(0.2 * x + 0.3 * y + c) +
                    noise.uniform(-0.1, 0.1));
        const double level = std::min(most, std::max(0.0, value));
        if (CV_MAT_DEPTH(type) == CV_8U)
          picture.ptr(y)[x * channels + c] = static_cast<uint8_t>(level);
        else
          picture.ptr<uint16_t>(y)[x * channels + c] =
              static_cast<uint16_t>(level);
      }
  return picture;
}

std::string EncodedByOpenCv(const std::string& extension, const cv::Mat& pixels,
                            const std::vector<int>& parameters = {}) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(extension, pixels, bytes, parameters));
  return {bytes.begin(), bytes.end()};
}

cv::Mat DecodedByOpenCv(const std::string& bytes, PixelConversion conversion) {
  const int flags =
      static_cast<int>(conversion) | cv::IMREAD_IGNORE_ORIENTATION;
  return cv::imdecode(std::vector<uint8_t>(bytes.begin(), bytes.end()), flags);
}

void ExpectTheSamePixels(const std::string& bytes, const std::string& what) {
  for (const PixelConversion conversion : kConversions) {
    SCOPED_TRACE(what + ", conversion " + std::to_string(int(conversion)));
    const cv::Mat expected = DecodedByOpenCv(bytes, conversion);
    const cv::Mat decoded = DecodeImage(bytes, conversion);
    ASSERT_EQ(decoded.size(), expected.size());
    ASSERT_EQ(decoded.type(), expected.type());
    if (decoded.empty()) continue;
    EXPECT_EQ(cv::norm(decoded, expected, cv::NORM_INF), 0);
  }
}

struct Kind {
  const char* extension;
  std::vector<int> types, parameters;
};

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kinds = {
      {".png", {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}, {}},
      {".jpg", {CV_8UC1, CV_8UC3}, {cv::IMWRITE_JPEG_QUALITY, 80}},
      {".jpg", {CV_8UC3}, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}},
      {".tif", {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}, {}},
      {".tif", {CV_8UC1, CV_8UC3, CV_16UC1}, {cv::IMWRITE_TIFF_COMPRESSION, 1}},
      {".bmp", {CV_8UC1, CV_8UC3}, {}},
      {".pgm", {CV_8UC1, CV_16UC1}, {}},
      {".ppm", {CV_8UC3, CV_16UC3}, {}},
      {".pgm", {CV_8UC1, CV_16UC1}, {cv::IMWRITE_PXM_BINARY, 0}},
      {".webp", {CV_8UC3, CV_8UC4}, {}},
      {".webp", {CV_8UC3}, {cv::IMWRITE_WEBP_QUALITY, 60}}};
  return kinds;
}

TEST(ImageCodecs, ReadThePixelsThatOpenCvReads) {
  for (const Kind& kind : Kinds())
    for (const int type : kind.types)
      ExpectTheSamePixels(
          EncodedByOpenCv(kind.extension, Picture(type), kind.parameters),
          std::string(kind.extension) + " of type " + std::to_string(type));
}

TEST(ImageCodecs, WriteTheBytesThatOpenCvWrites) {
  for (const int type :
       {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
    SCOPED_TRACE(type);
    EXPECT_TRUE(EncodePng(Picture(type)) ==
                EncodedByOpenCv(".png", Picture(type)));
  }
  const std::vector<int> parameters = {cv::IMWRITE_JPEG_QUALITY, 55};
  EXPECT_TRUE(EncodeJpeg(Picture(CV_8UC1), 55) ==
              EncodedByOpenCv(".jpg", Picture(CV_8UC1), parameters));
}

// Damage may leave an image that decoders complete. Memory is not touched
// beyond the file, which sanitizers see.
TEST(ImageCodecs, SurviveDamage) {
  cv::RNG random(3);
  for (const Kind& kind : Kinds()) {
    const std::string whole = EncodedByOpenCv(
        kind.extension, Picture(kind.types.back()), kind.parameters);
    EXPECT_TRUE(DecodeImage(whole.substr(0, 40), kConversions[0]).empty())
        << kind.extension;
    for (int round = 0; round < 100; ++round) {
      std::string bytes =
          whole.substr(0, random.uniform(12, int(whole.size())));
      // Sizes are checked before a decoder is called, so they stay.
      for (int i = 0; i < 3; ++i)
        bytes[random.uniform(0, int(bytes.size()))] ^=
            static_cast<char>(1 << random.uniform(0, 8));
      const cv::Mat decoded =
          round % 2
              ? DecodeImage(bytes, kConversions[round % 4])
              : DecodeImage(whole.substr(0, bytes.size()), kConversions[2]);
      EXPECT_LT(decoded.total(), size_t(1) << 31);
    }
  }
}

}  // namespace
}  // namespace raygrid
