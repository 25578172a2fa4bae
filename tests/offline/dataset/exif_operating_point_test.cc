#include "dataset/exif_operating_point.h"

#include <array>
#include <opencv2/imgcodecs.hpp>

#include "dataset/image_header.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr uint32_t kSubjectDistance = 0x9206, kAmbientTemperature = 0x9400,
                   kRational = 5, kSignedRational = 10;

// EXIF data of either byte order: a directory whose only entry points to EXIF's
// own, which has one tag of two numbers.
std::string ExifOf(bool is_big_endian, uint32_t tag, uint32_t type,
                   uint32_t numerator, uint32_t denominator) {
  std::string exif = is_big_endian ? "MM" : "II";
  const auto add = [&](uint32_t number, int count) {
    for (int i = 0; i < count; ++i)
      exif += static_cast<char>(
          number >> 8 * (is_big_endian ? count - 1 - i : i) & 255);
  };
  const auto add_entry = [&](uint32_t entry_tag, uint32_t entry_type,
                             uint32_t value) {
    add(1, 2);
    add(entry_tag, 2);
    add(entry_type, 2);
    add(1, 4);
    add(value, 4);
    add(0, 4);
  };
  constexpr uint32_t kExifDirectory = 0x8769, kLong = 4;
  add(42, 2);
  add(8, 4);
  add_entry(kExifDirectory, kLong, 26);
  add_entry(tag, type, 44);
  add(numerator, 4);
  add(denominator, 4);
  return exif;
}

std::string EncodedImage(const char* extension) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(extension, cv::Mat(40, 60, CV_8U, 77), bytes));
  return {bytes.begin(), bytes.end()};
}

std::string BigEndian(size_t number, int count) {
  std::string bytes;
  for (int i = count - 1; i >= 0; --i)
    bytes += static_cast<char>(number >> 8 * i & 255);
  return bytes;
}

std::string JpegWith(const std::string& exif) {
  const std::string jpeg = EncodedImage(".jpg");
  return jpeg.substr(0, 2) + "\xff\xe1" + BigEndian(exif.size() + 8, 2) +
         std::string("Exif\0\0", 6) + exif + jpeg.substr(2);
}

// Readers of headers do not check a chunk's sum.
std::string PngWith(const std::string& exif) {
  const std::string png = EncodedImage(".png");
  return png.substr(0, 33) + BigEndian(exif.size(), 4) + "eXIf" + exif +
         std::string(4, '\0') + png.substr(33);
}

std::string WebpWith(const std::string& exif) {
  std::string size = BigEndian(exif.size(), 4);
  std::reverse(size.begin(), size.end());
  return EncodedImage(".webp") + "EXIF" + size + exif;
}

std::optional<double> DioptresOf(uint32_t numerator, uint32_t denominator) {
  return ReadExifParameter("a.jpg",
                           JpegWith(ExifOf(true, kSubjectDistance, kRational,
                                           numerator, denominator)),
                           OperatingParameter::kLensPosition);
}

std::optional<double> DegreesOf(int numerator, int denominator) {
  return ReadExifParameter(
      "a.jpg",
      JpegWith(ExifOf(false, kAmbientTemperature, kSignedRational,
                      static_cast<uint32_t>(numerator),
                      static_cast<uint32_t>(denominator))),
      OperatingParameter::kTemperature);
}

TEST(ReadExifParameter, IsOneOverTheDistance) {
  EXPECT_EQ(DioptresOf(1, 4), 4);
  EXPECT_EQ(DioptresOf(1000, 3250), 3.25);
  EXPECT_EQ(DioptresOf(50, 1), 0.02);
}

TEST(ReadExifParameter, KnowsInfinityAndWhatIsNotKnown) {
  EXPECT_EQ(DioptresOf(0xffffffff, 1), 0);
  EXPECT_EQ(DioptresOf(0xffffffff, 0xffffffff), 0);
  EXPECT_EQ(DioptresOf(1000, 0), 0);
  EXPECT_EQ(DioptresOf(0, 1), std::nullopt);
  EXPECT_EQ(DioptresOf(0, 0), std::nullopt);
}

TEST(ReadExifParameter, IsTheTemperatureInDegrees) {
  EXPECT_EQ(DegreesOf(2150, 100), 21.5);
  EXPECT_EQ(DegreesOf(-7, 2), -3.5);
  EXPECT_EQ(DegreesOf(0, 1), 0);
  EXPECT_EQ(DegreesOf(30, -1), std::nullopt);
  EXPECT_EQ(DegreesOf(30, 0), std::nullopt);
}

TEST(ReadExifParameter, IsReadFromEveryKindThatHasIt) {
  for (const bool is_big_endian : {false, true}) {
    const std::string exif =
        ExifOf(is_big_endian, kSubjectDistance, kRational, 2, 5);
    for (const std::string& file :
         {JpegWith(exif), PngWith(exif), WebpWith(exif),
          WebpWith(std::string("Exif\0\0", 6) + exif)}) {
      EXPECT_EQ(ReadExifParameter("a", file, OperatingParameter::kLensPosition),
                2.5);
      EXPECT_EQ(ReadExifParameter("a", file, OperatingParameter::kTemperature),
                std::nullopt);
    }
  }
  for (const char* extension : {".jpg", ".png", ".webp", ".tif", ".bmp"})
    EXPECT_EQ(ReadExifParameter("a", EncodedImage(extension),
                                OperatingParameter::kLensPosition),
              std::nullopt);
}

TEST(ReadExifParameter, AnotherTypeTellsNothing) {
  constexpr uint32_t kText = 2, kShort = 3;
  for (const uint32_t type : {kText, kShort, kSignedRational, 99u})
    EXPECT_EQ(ReadExifParameter(
                  "a", JpegWith(ExifOf(true, kSubjectDistance, type, 1, 2)),
                  OperatingParameter::kLensPosition),
              std::nullopt);
}

// Each byte of the EXIF data in turn, and each length: a value, nothing, or a
// file that is refused.
TEST(ReadExifParameter, DamageIsHarmless) {
  const std::string exif = ExifOf(false, kSubjectDistance, kRational, 1, 3);
  int num_reported = 0;
  for (size_t k = 0; k < exif.size(); ++k) {
    for (const int flip : {1, 0x80, 0xff}) {
      std::string damaged = exif;
      damaged[k] = static_cast<char>(damaged[k] ^ flip);
      num_reported += ReadExifParameter("a", PngWith(damaged),
                                        OperatingParameter::kLensPosition)
                          .has_value();
    }
    EXPECT_EQ(ReadExifParameter("a", PngWith(exif.substr(0, k)),
                                OperatingParameter::kLensPosition),
              std::nullopt)
        << k;
  }
  EXPECT_GT(num_reported, 20);  // of numbers that are others
  const std::string jpeg = JpegWith(exif);
  for (size_t size = 0; size < 120; ++size) {
    try {
      ReadExifParameter("a", jpeg.substr(0, size),
                        OperatingParameter::kLensPosition);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("corrupt"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace raygrid
