#include "features/tag_detection.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagStandard41h12.h>
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace raygrid {
namespace {

struct Family {
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

cv::Mat View(const GreyImage& image) {
  return cv::Mat(image.size.height, image.size.width, CV_8U,
                 const_cast<uint8_t*>(image.bytes.data()));
}

// libapriltag puts (0, 0) at the corner of the top-left pixel.
Eigen::Vector2d FromPixelCorner(const double position[2], double scale) {
  return {position[0] / scale - 0.5, position[1] / scale - 0.5};
}

// In an image enlarged by scale; squares are sought in every decimate-th row
// and column, corners are found in all.
std::vector<DetectedTag> Detect(const cv::Mat& image, const Family& kind,
                                double scale, float decimate = 1) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(
      kind.create(), kind.destroy);
  const std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)>
      detector(apriltag_detector_create(), apriltag_detector_destroy);
  // Behind a fisheye a tag's cells lie a little beside where a homography
  // expects them: one wrong bit is forgiven; eleven make another tag.
  apriltag_detector_add_family_bits(detector.get(), family.get(), 1);
  detector->nthreads = 1;
  detector->quad_decimate = decimate;
  // ... and its edges are curved: squared pixels that they may be off a line.
  detector->qtp.max_line_fit_mse = 60;
  image_u8_t view = {image.cols, image.rows, static_cast<int32_t>(image.step),
                     image.data};
  zarray_t* found = apriltag_detector_detect(detector.get(), &view);
  std::vector<DetectedTag> tags;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* detection;
    zarray_get(found, i, &detection);
    DetectedTag tag;
    tag.id = detection->id;
    // From the bottom left, counter-clockwise.
    for (int k = 0; k < 4; ++k)
      tag.corners[k] = FromPixelCorner(detection->p[3 - k], scale);
    constexpr float kMinMargin = 20;
    if (detection->decision_margin > kMinMargin) tags.push_back(tag);
  }
  apriltag_detections_destroy(found);
  std::sort(
      tags.begin(), tags.end(),
      [](const DetectedTag& a, const DetectedTag& b) { return a.id < b.id; });
  return tags;
}

constexpr Family kTag36h11 = {tag36h11_create, tag36h11_destroy};

}  // namespace

std::vector<DetectedTag> DetectTags(const GreyImage& image) {
  constexpr int kMinPixelsToDecimate = 500000, kMaxPixelsToEnlarge = 2000000;
  std::vector<DetectedTag> tags;
  if (image.size.width * image.size.height >= kMinPixelsToDecimate)
    tags = Detect(View(image), kTag36h11, 1, 2);
  if (tags.empty()) tags = Detect(View(image), kTag36h11, 1);
  if (!tags.empty() ||
      image.size.width * image.size.height > kMaxPixelsToEnlarge)
    return tags;
  cv::Mat enlarged;
  cv::resize(View(image), enlarged, cv::Size(), 2, 2, cv::INTER_CUBIC);
  return Detect(enlarged, kTag36h11, 2);
}

std::vector<std::string> DescribeOtherTags(const GreyImage& image) {
  std::vector<std::string> seen;
  cv::Mat mirrored;
  cv::flip(View(image), mirrored, 1);
  for (const DetectedTag& tag : Detect(mirrored, kTag36h11, 1))
    seen.push_back(fmt::format("mirrored tag {}", tag.id));
  const std::pair<const char*, Family> others[] = {
      {"tag25h9", {tag25h9_create, tag25h9_destroy}},
      {"tagStandard41h12",
       {tagStandard41h12_create, tagStandard41h12_destroy}}};
  for (const auto& [name, family] : others)
    for (const DetectedTag& tag : Detect(View(image), family, 1))
      seen.push_back(fmt::format("tag {} of family {}", tag.id, name));
  return seen;
}

}  // namespace raygrid
