// JPEG files that are cut, or that more follows.

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "dataset/image_files.h"
#include "support.h"

namespace raygrid {
namespace {

std::string Jpeg(const std::vector<int>& parameters) {
  cv::Mat image(120, 160, CV_8UC3);
  cv::randu(image, 0, 256);
  cv::GaussianBlur(image, image, cv::Size(), 1.5);
  std::vector<uint8_t> bytes;
  cv::imencode(".jpg", image, bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

// A thumbnail with an end of its own, within a segment.
std::string WithThumbnail(const std::string& jpeg) {
  const std::string thumbnail = Jpeg({cv::IMWRITE_JPEG_QUALITY, 20});
  const size_t length = thumbnail.size() + 2;
  return jpeg.substr(0, 2) + "\xff\xe1" + static_cast<char>(length >> 8) +
         static_cast<char>(length & 255) + thumbnail + jpeg.substr(2);
}

const std::vector<std::vector<int>> kKindsOfJpeg = {
    {},
    {cv::IMWRITE_JPEG_PROGRESSIVE, 1},
    {cv::IMWRITE_JPEG_RST_INTERVAL, 3},
    {cv::IMWRITE_JPEG_OPTIMIZE, 1}};

TEST(JpegEnd, WhatFollowsAJpegDoesNotMatter) {
  const std::string zeros(34000, '\0'), notes(300000, '\xff');
  const std::string video = "ftypmp42" + std::string(3 << 20, 'v') + "\xff\xd8";
  for (const auto& parameters : kKindsOfJpeg) {
    const std::string jpeg = WithThumbnail(Jpeg(parameters));
    const std::vector<float> levels = DecodeGreyLevels("a", jpeg).levels;
    for (const std::string& trailer : {zeros, notes, video, jpeg})
      EXPECT_EQ(DecodeGreyLevels("a", jpeg + trailer).levels, levels);
  }
}

TEST(JpegEnd, CutJpegIsRefusedWhateverFollows) {
  const std::string zeros(34000, '\0');
  for (const auto& parameters : kKindsOfJpeg) {
    const std::string jpeg = WithThumbnail(Jpeg(parameters));
    for (const double part : {0.3, 0.6, 0.9, 0.99}) {
      const auto size = static_cast<size_t>(part * jpeg.size());
      const std::string cut = jpeg.substr(0, size);
      for (const std::string& file : {cut, cut + zeros, cut + "\xff\xd9"}) {
        // A scan of several that is whole looks like the only one.
        if (parameters == kKindsOfJpeg[1] && file != cut && file != cut + zeros)
          continue;
        ExpectError(ExitCode::kInvalidInput, {"a", "corrupt"},
                    [&] { DecodeGreyLevels("a", file); });
      }
    }
  }
}

TEST(JpegEnd, JpegWithoutAnEndIsWholeIfItsScanIs) {
  for (const auto& parameters : kKindsOfJpeg) {
    const std::string jpeg = Jpeg(parameters);
    const std::string endless = jpeg.substr(0, jpeg.size() - 2);
    if (parameters == kKindsOfJpeg[1])
      ExpectError(ExitCode::kInvalidInput, {"a", "corrupt"},
                  [&] { DecodeGreyLevels("a", endless); });
    else
      EXPECT_EQ(DecodeGreyLevels("a", endless).levels,
                DecodeGreyLevels("a", jpeg).levels);
  }
}

}  // namespace
}  // namespace raygrid
