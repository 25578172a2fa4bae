#include "features/board_view/tag_detection.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagStandard41h12.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace raygrid {
namespace {

using FamilyPointer =
    std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;
using DetectorPointer =
    std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)>;

// Adds a black border cell: code cells are counted from the corner of the black
// square.
FamilyPointer WidenBorder(FamilyPointer family) {
  for (uint32_t bit = 0; bit < family->nbits; ++bit) {
    ++family->bit_x[bit];
    ++family->bit_y[bit];
  }
  family->width_at_border += 2;
  family->total_width += 2;
  return family;
}

FamilyPointer MakeFamily(TagFamily kind) {
  switch (kind) {
    case TagFamily::k25h9:
      return {tag25h9_create(), tag25h9_destroy};
    case TagFamily::k16h5:
      return {tag16h5_create(), tag16h5_destroy};
    case TagFamily::kStandard41h12:
      return {tagStandard41h12_create(), tagStandard41h12_destroy};
    case TagFamily::k36h11WideBorder:
      return WidenBorder(MakeFamily(TagFamily::k36h11));
    case TagFamily::k25h9WideBorder:
      return WidenBorder(MakeFamily(TagFamily::k25h9));
    case TagFamily::k16h5WideBorder:
      return WidenBorder(MakeFamily(TagFamily::k16h5));
    default:
      return {tag36h11_create(), tag36h11_destroy};
  }
}

cv::Mat View(const GreyImage& image) {
  return cv::Mat(image.size.height, image.size.width, CV_8U,
                 const_cast<uint8_t*>(image.bytes.data()));
}

// Returns the quantile of the grey levels at the given fraction.
int Quantile(const std::vector<uint8_t>& bytes, double part) {
  std::array<size_t, 256> histogram = {};
  for (const uint8_t byte : bytes) ++histogram[byte];
  const auto limit =
      static_cast<size_t>(part * static_cast<double>(bytes.size()));
  size_t below = 0;
  int level = 0;
  while (level < 255 && (below += histogram[level]) <= limit) ++level;
  return level;
}

// libapriltag's thresholds are absolute grey levels, so dark images are
// amplified.
cv::Mat BrightenImage(const GreyImage& image) {
  constexpr double kBright = 200, kMinGain = 1.5, kMaxGain = 8;
  const double gain =
      std::min(kMaxGain, kBright / std::max(1, Quantile(image.bytes, 0.99)));
  if (gain < kMinGain) return View(image);
  const cv::Mat levels(image.size.height, image.size.width, CV_32F,
                       const_cast<float*>(image.levels.data()));
  cv::Mat brightened;
  levels.convertTo(brightened, CV_8U, gain);
  return brightened;
}

// libapriltag stores coordinates of the decimated image in 15 bits.
float ComputeMinDecimation(const cv::Mat& image) {
  constexpr int kMaxLookedAt = 32767;
  return static_cast<float>(1 + (std::max(image.cols, image.rows) - 1) /
                                    kMaxLookedAt);
}

// In libapriltag, (0, 0) is the corner of the top-left pixel.
Eigen::Vector2d FromPixelCorner(const double position[2]) {
  return {position[0] - 0.5, position[1] - 0.5};
}

}  // namespace

struct TagDetector::Data {
  std::vector<TagFamily> kinds;
  std::vector<FamilyPointer> families;
  DetectorPointer detector;
  float decimate, min_margin;
};

TagDetector::TagDetector(const std::vector<TagFamily>& families,
                         const TagOptions& options)
    : data_(new Data{families,
                     {},
                     {apriltag_detector_create(), apriltag_detector_destroy},
                     options.decimate,
                     options.min_margin}) {
  apriltag_detector_t* detector = data_->detector.get();
  for (const TagFamily kind : families) {
    data_->families.push_back(MakeFamily(kind));
    const bool is_small =
        kind == TagFamily::k16h5 || kind == TagFamily::k16h5WideBorder;
    apriltag_detector_add_family_bits(detector, data_->families.back().get(),
                                      is_small ? 0 : options.max_wrong_bits);
  }
  detector->nthreads = 1;
  detector->qtp.max_line_fit_mse = options.max_line_fit_mse;
}
TagDetector::~TagDetector() = default;

std::vector<DetectedTag> TagDetector::Detect(const cv::Mat& image) const {
  if (!IsLargeEnough({image.cols, image.rows})) return {};
  data_->detector->quad_decimate =
      std::max(data_->decimate, ComputeMinDecimation(image));
  image_u8_t view = {image.cols, image.rows, static_cast<int32_t>(image.step),
                     image.data};
  zarray_t* found = apriltag_detector_detect(data_->detector.get(), &view);
  std::vector<DetectedTag> tags;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* detection;
    zarray_get(found, i, &detection);
    if (detection->decision_margin < data_->min_margin) continue;
    DetectedTag tag;
    tag.id = detection->id;
    for (size_t k = 0; k < data_->families.size(); ++k)
      if (detection->family == data_->families[k].get())
        tag.family = data_->kinds[k];
    // libapriltag orders corners counter-clockwise from the bottom left.
    for (int k = 0; k < 4; ++k)
      tag.corners[k] = FromPixelCorner(detection->p[3 - k]);
    tags.push_back(tag);
  }
  apriltag_detections_destroy(found);
  std::stable_sort(
      tags.begin(), tags.end(),
      [](const DetectedTag& a, const DetectedTag& b) { return a.id < b.id; });
  return tags;
}

namespace {

// With a fisheye, tag cells deviate from the positions predicted by the
// homography, and edges are curved. One bit error is corrected; tag36h11 has a
// minimum Hamming distance of 11.
TagOptions MakeStarBoardOptions(float decimate) {
  TagOptions options;
  options.decimate = decimate;
  options.max_wrong_bits = 1;
  options.max_line_fit_mse = 60;
  options.min_margin = 20;
  return options;
}

std::vector<DetectedTag> DetectTagsInImage(const cv::Mat& image,
                                           TagFamily family, float decimate) {
  return TagDetector({family}, MakeStarBoardOptions(decimate)).Detect(image);
}

float QuickDecimation(const ImageSize& size) {
  return IsQuickSearchThorough(size) ? 1 : 2;
}

}  // namespace

bool IsQuickSearchThorough(const ImageSize& size) {
  constexpr int kMinPixelsToDecimate = 500000;
  return size.width * size.height < kMinPixelsToDecimate;
}

std::vector<DetectedTag> DetectTags(const GreyImage& image, TagSearch search) {
  return DetectTagsInImage(
      BrightenImage(image), TagFamily::k36h11,
      search == TagSearch::kThorough ? 1 : QuickDecimation(image.size));
}

std::vector<std::string> DescribeOtherTags(const GreyImage& image) {
  std::vector<std::string> seen;
  const float decimate = QuickDecimation(image.size);
  const cv::Mat view = BrightenImage(image);
  cv::Mat mirrored;
  cv::flip(view, mirrored, 1);
  for (const DetectedTag& tag :
       DetectTagsInImage(mirrored, TagFamily::k36h11, decimate))
    seen.push_back(fmt::format("mirrored tag {}", tag.id));
  const std::pair<const char*, TagFamily> others[] = {
      {"tag25h9", TagFamily::k25h9},
      {"tagStandard41h12", TagFamily::kStandard41h12}};
  for (const auto& [name, family] : others)
    for (const DetectedTag& tag : DetectTagsInImage(view, family, decimate))
      seen.push_back(fmt::format("tag {} of family {}", tag.id, name));
  return seen;
}

}  // namespace raygrid
