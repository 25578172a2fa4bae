#include "features/aprilgrid.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "features/seen_markers.h"

namespace raygrid {
namespace {

// A tag as libapriltag reports it.
struct FoundTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners_px;  // clockwise as printed
};

// libapriltag has (0, 0) at the corner of the first pixel.
Eigen::Vector2d PixelFromAprilTag(const double* p) {
  return {p[0] - 0.5, p[1] - 0.5};
}

// tag36h11 with one more black cell around the code. Cells count from the
// corner of the black square.
struct TagFamily {
  TagFamily() : family(tag36h11_create()) {
    for (uint32_t bit = 0; bit < family->nbits; ++bit) {
      ++family->bit_x[bit];
      ++family->bit_y[bit];
    }
    family->width_at_border += 2;
    family->total_width += 2;
  }
  ~TagFamily() { tag36h11_destroy(family); }
  TagFamily(const TagFamily&) = delete;
  TagFamily& operator=(const TagFamily&) = delete;

  apriltag_family_t* family;
};

// libapriltag's detectors serve one thread each.
class TagDetector {
 public:
  TagDetector() : detector_(apriltag_detector_create()) {
    detector_->nthreads = 1;
    detector_->quad_decimate = 1;
    apriltag_detector_add_family(detector_, family_.family);
  }
  ~TagDetector() { apriltag_detector_destroy(detector_); }
  TagDetector(const TagDetector&) = delete;
  TagDetector& operator=(const TagDetector&) = delete;

  std::vector<FoundTag> Detect(const cv::Mat& image) {
    image_u8_t view = {image.cols, image.rows, static_cast<int32_t>(image.step),
                       image.data};
    zarray_t* detections = apriltag_detector_detect(detector_, &view);
    std::vector<FoundTag> found;
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* detection;
      zarray_get(detections, i, &detection);
      FoundTag tag;
      tag.id = detection->id;
      // From the bottom left, counter-clockwise.
      for (int k = 0; k < 4; ++k)
        tag.corners_px[k] = PixelFromAprilTag(detection->p[3 - k]);
      found.push_back(tag);
    }
    apriltag_detections_destroy(detections);
    return found;
  }

 private:
  TagFamily family_;
  apriltag_detector_t* detector_;
};

// Black squares touch the corners of the tags, and blur joins them to one shape
// that is no square. Where white has grown into black by some pixels, they are
// apart.
constexpr int kMaxGrowthPx = 3;

cv::Mat WithWhiteGrown(const cv::Mat& image, int growth_px) {
  cv::Mat grown;
  const int side = 2 * growth_px + 1;
  cv::dilate(image, grown, cv::Mat::ones(side, side, CV_8U));
  return grown;
}

// The corners before white had grown.
void UndoGrowth(int growth_px, FoundTag* tag) {
  const std::array<Eigen::Vector2d, 4> c = tag->corners_px;
  for (int k = 0; k < 4; ++k)
    tag->corners_px[k] += growth_px * ((c[k] - c[(k + 1) % 4]).normalized() +
                                       (c[k] - c[(k + 3) % 4]).normalized());
}

std::vector<FoundTag> FindTags(const GreyImage& image) {
  const cv::Mat grey(image.size.height, image.size.width, CV_8U,
                     const_cast<uint8_t*>(image.bytes.data()));
  TagDetector detector;
  std::vector<FoundTag> found = detector.Detect(grey);
  for (int growth_px = 1; growth_px <= kMaxGrowthPx; ++growth_px) {
    const size_t num_before = found.size();
    for (FoundTag& tag : detector.Detect(WithWhiteGrown(grey, growth_px))) {
      if (std::any_of(found.begin(), found.begin() + num_before,
                      [&](const FoundTag& f) { return f.id == tag.id; }))
        continue;
      UndoGrowth(growth_px, &tag);
      found.push_back(tag);
    }
  }
  return found;
}

}  // namespace

struct AprilGridLocator::Data {
  explicit Data(const Board& b)
      : board(b), markers(BoardAppearance(b).markers()) {}

  Board board;
  std::vector<PlacedMarker> markers;

  std::vector<SeenMarker> OnBoard(const std::vector<FoundTag>& tags,
                                  int quarter_turns) const;
  MarkerConstellation Constellation(const std::vector<FoundTag>& tags) const;
  void AddCorners(const SeenMarker& tag, std::vector<Feature>* features) const;
  double pitch_m() const { return board.square_m * (1 + board.spacing_ratio); }
};

// The board's tags, each turned on the page as often as stated.
std::vector<SeenMarker> AprilGridLocator::Data::OnBoard(
    const std::vector<FoundTag>& tags, int quarter_turns) const {
  std::vector<SeenMarker> seen;
  for (const FoundTag& tag : tags) {
    const auto place = std::find_if(
        markers.begin(), markers.end(),
        [&](const PlacedMarker& marker) { return marker.id == tag.id; });
    if (place == markers.end()) continue;
    SeenMarker marker;
    marker.index = static_cast<int>(place - markers.begin());
    for (int k = 0; k < 4; ++k)
      marker.corners_px[k] = tag.corners_px[(k + quarter_turns) % 4];
    seen.push_back(marker);
  }
  return seen;
}

// Generators of boards do not agree which side of a tag is up: the way that
// makes neighbours fit together is the right one.
MarkerConstellation AprilGridLocator::Data::Constellation(
    const std::vector<FoundTag>& tags) const {
  MarkerConstellation best(markers, pitch_m(), OnBoard(tags, 0));
  for (int quarter_turns = 1; quarter_turns < 4; ++quarter_turns) {
    const MarkerConstellation turned(markers, pitch_m(),
                                     OnBoard(tags, quarter_turns));
    if (turned.Agreement() > best.Agreement()) best = turned;
  }
  return best;
}

void AprilGridLocator::Data::AddCorners(const SeenMarker& tag,
                                        std::vector<Feature>* features) const {
  const Eigen::Vector2d place = markers[tag.index].corner / pitch_m();
  const int column = 2 * static_cast<int>(std::lround(place.x()));
  const int row = 2 * static_cast<int>(std::lround(place.y()));
  features->push_back({board.id, column, row, tag.corners_px[0]});
  features->push_back({board.id, column + 1, row, tag.corners_px[1]});
  features->push_back({board.id, column + 1, row + 1, tag.corners_px[2]});
  features->push_back({board.id, column, row + 1, tag.corners_px[3]});
}

AprilGridLocator::AprilGridLocator(const Board& board)
    : data_(std::make_unique<Data>(board)) {}
AprilGridLocator::~AprilGridLocator() = default;

ImageDetection AprilGridLocator::Locate(const GreyImage& image) const {
  const std::vector<FoundTag> tags = FindTags(image);
  const MarkerConstellation seen = data_->Constellation(tags);
  const MarkerConstellation fitting = seen.Consistent();
  ImageDetection located;
  for (const SeenMarker& tag : fitting.seen())
    data_->AddCorners(tag, &located.features);
  if (seen.size() > 0 && fitting.size() == 0)
    located.remarks.push_back(
        fmt::format("board {}: {} tags that do not fit together",
                    data_->board.id, seen.size()));
  if (seen.size() == 0 && !tags.empty())
    located.remarks.push_back(
        fmt::format("tag {} is not on board {}", tags[0].id, data_->board.id));
  return located;
}

}  // namespace raygrid
