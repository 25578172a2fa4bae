#include "dataset/image_header.h"

#include <opencv2/imgcodecs.hpp>

#include "dataset/files.h"
#include "dataset/image_files.h"
#include "support.h"

namespace raygrid {
namespace {

std::string Encode(const std::string& extension, const cv::Mat& image,
                   const std::vector<int>& parameters = {}) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, parameters));
  return {bytes.begin(), bytes.end()};
}

cv::Mat Noise(int type) {
  cv::Mat image(23, 37, type);
  cv::randu(image, 0, 256);
  return image;
}

std::vector<std::string> OneOfEachKind() {
  std::vector<std::string> files;
  for (const char* extension :
       {".png", ".jpg", ".tif", ".bmp", ".ppm", ".webp"})
    files.push_back(Encode(extension, Noise(CV_8UC3)));
  files.push_back(Encode(".pgm", Noise(CV_8U)));
  files.push_back(Encode(".webp", Noise(CV_8UC3),
                         {cv::IMWRITE_WEBP_QUALITY, 101}));  // lossless
  files.push_back(Encode(".webp", Noise(CV_8UC4)));
  files.push_back(Encode(".tif", Noise(CV_16U)));
  files.push_back(
      Encode(".jpg", Noise(CV_8U), {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  files.push_back("P2 # plain\n37 #wide\n23\n255\n" + std::string(2000, ' '));
  return files;
}

// With what EXIF says of showing it, behind the first two bytes.
std::string WithExif(const std::string& jpeg, int orientation) {
  std::string exif("Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0",
                   25);
  exif += static_cast<char>(orientation);
  exif += std::string(6, '\0');
  const std::string segment =
      std::string("\xff\xe1\0", 3) + static_cast<char>(exif.size() + 2) + exif;
  return jpeg.substr(0, 2) + segment + jpeg.substr(2);
}

TEST(ImageHeader, EveryKindSaysItsSize) {
  for (const std::string& file : OneOfEachKind()) {
    const ImageHeader header = ParseImageHeader("a", file);
    EXPECT_EQ(header.size, (ImageSize{37, 23})) << file.substr(0, 4);
    EXPECT_EQ(header.orientation, 1);
  }
}

TEST(ImageHeader, WhatIsCutIsRefusedOrKnownByItsStart) {
  for (const std::string& file : OneOfEachKind()) {
    for (size_t size = 0; size < file.size(); ++size) {
      try {
        const ImageHeader header = ParseImageHeader("a", file.substr(0, size));
        EXPECT_LE(header.size.width, 37);
        EXPECT_LE(header.size.height, 23);
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("corrupt"), std::string::npos);
      }
    }
  }
}

TEST(ImageHeader, JpegSaysHowItIsToBeShown) {
  const TemporaryFolder folder;
  const std::string upright = Encode(".jpg", Noise(CV_8UC3));
  WriteFile(folder / "upright.jpg", upright);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::string turned = WithExif(upright, orientation);
    EXPECT_EQ(ParseImageHeader("a", turned).orientation, orientation);
    WriteFile(folder / "turned.jpg", turned);
    const Image image = ReadImage(folder / "turned.jpg", true);
    EXPECT_EQ(image.is_turned, orientation != 1);
    EXPECT_EQ(image.pixels, ReadImage(folder / "upright.jpg", true).pixels);
    EXPECT_EQ(ReadGreyLevels(folder / "turned.jpg").levels,
              ReadGreyLevels(folder / "upright.jpg").levels);
  }
  // An orientation that no standard knows counts as upright, and so does a file
  // that ends before it says one.
  EXPECT_EQ(ParseImageHeader("a", WithExif(upright, 9)).orientation, 1);
  std::string damaged = WithExif(upright, 6);
  damaged[17] = '\x7f';  // the directory lies beyond the file
  EXPECT_EQ(ParseImageHeader("a", damaged).orientation, 1);
}

// A TIFF file's directory alone, of little-endian 32-bit numbers.
std::string Tiff(const std::vector<std::array<uint32_t, 3>>& entries) {
  std::string file("II*\0\x08\0\0\0", 8);
  const auto add = [&file](uint32_t number, int bytes) {
    for (int i = 0; i < bytes; ++i)
      file += static_cast<char>(number >> 8 * i & 255);
  };
  add(static_cast<uint32_t>(entries.size()), 2);
  for (const auto& [tag, type, value] : entries) {
    add(tag, 2);
    add(type, 2);
    add(1, 4);
    add(value, 4);
  }
  add(0, 4);
  return file;
}

void ExpectHeaderRefused(const std::string& file, const std::string& word) {
  ExpectError(ExitCode::kInvalidInput, {"a.tif", word},
              [&] { ParseImageHeader("a.tif", file); });
}

TEST(ImageHeader, LargerImagesThanAllowedAreRefused) {
  EXPECT_EQ(ParseImageHeader("a", "P5 16384 1024 255\n").size.width, 16384);
  ExpectHeaderRefused("P5 16385 1 255\n", "--allow-huge-images");
  ExpectHeaderRefused("P5 1 4294967936 255\n", "--allow-huge-images");
  ExpectHeaderRefused("P5 99999999999999999999999 1 255\n",
                      "--allow-huge-images");
  ExpectHeaderRefused("P5 0 640 255\n", "corrupt");
  constexpr uint32_t kWidth = 256, kHeight = 257, kTileWidth = 322, kLong = 4,
                     kSignedLong = 9, kLong8 = 16;
  ExpectHeaderRefused(Tiff({{kWidth, kLong, 20000}, {kHeight, kLong, 1}}),
                      "--allow-huge-images");
  // The first of two is what a decoder may take, or the last.
  ExpectHeaderRefused(
      Tiff({{kWidth, kLong, 20000}, {kWidth, kLong, 8}, {kHeight, kLong, 1}}),
      "--allow-huge-images");
  ExpectHeaderRefused(Tiff({{kWidth, kLong, 8},
                            {kHeight, kLong, 8},
                            {kTileWidth, kLong, 1 << 20}}),
                      "--allow-huge-images");
  for (const uint32_t type : {kSignedLong, kLong8})
    ExpectHeaderRefused(
        Tiff({{kWidth, type, 20000}, {kWidth, kLong, 8}, {kHeight, kLong, 8}}),
        "corrupt");
}

TEST(ImageHeader, ManyPixelsOfFewBytesAreRefused) {
  const std::string small = "P5 4096 4096 255\n", many = "P5 4096 4097 255\n";
  EXPECT_EQ(ParseImageHeader("a", small).size.height, 4096);
  ExpectHeaderRefused(many, "4096 x 4097 pixels in 17 bytes");
  EXPECT_EQ(ParseImageHeader("a", many + std::string(33600, ' ')).size.height,
            4097);
  const std::string huge = "P5 16384 16384 255\n";
  ExpectHeaderRefused(huge + std::string(2600000, ' '), "--allow-huge-images");
  EXPECT_EQ(ParseImageHeader("a", huge + std::string(2700000, ' ')).size.height,
            16384);
}

TEST(ImageHeader, OtherKindsAreRefused) {
  for (const char* file : {"", "P", "P7\nWIDTH 3\n", "GIF89a", "#?RADIANCE\n"})
    ExpectHeaderRefused(file, "not an image");
}

}  // namespace
}  // namespace raygrid
