#include "features/squares/aprilgrid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "features/board_view/locators.h"
#include "features/squares/aruco_markers.h"
#include "features/squares/corner_growth.h"
#include "features/squares/detected_markers.h"

namespace raygrid {

/// Detects the tag corners of an AprilGrid approximately, with black squares at
/// the corners (Kalibr's layout) or without.
class AprilGridLocator {
 public:
  explicit AprilGridLocator(const Board& board);
  ~AprilGridLocator();

  ImageDetection Locate(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

namespace {

// In Kalibr's layout, black squares touch the corners of the tags, and blur
// merges them with the tag into a shape that is not a quad. Dilating the white
// areas by some pixels separates them. Small cells are resolved only in an
// enlarged image.
struct Preprocessing {
  int scale;
  int growth_px;  // dilation in pixels of the enlarged image
};
constexpr Preprocessing kPreprocessings[] = {{1, 0}, {2, 1}, {1, 1},
                                             {2, 2}, {1, 2}, {1, 3}};
constexpr double kMaxPixelsToEnlarge = 2.5e6;

constexpr double kMinCorrelations[] = {0.7, 0.6};

cv::Mat PreprocessImage(const cv::Mat& image,
                        const Preprocessing& preprocessing) {
  cv::Mat prepared = image;
  if (preprocessing.scale > 1)
    cv::resize(image, prepared, cv::Size(), preprocessing.scale,
               preprocessing.scale, cv::INTER_CUBIC);
  if (preprocessing.growth_px == 0) return prepared;
  const int side = 2 * preprocessing.growth_px + 1;
  cv::Mat grown;
  cv::dilate(prepared, grown, cv::Mat::ones(side, side, CV_8U));
  return grown;
}

// Converts the corners to the coordinates of the original image.
void Undo(const Preprocessing& preprocessing, DetectedTag* tag) {
  const std::array<Eigen::Vector2d, 4> c = tag->corners;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d outwards = (c[k] - c[(k + 1) % 4]).normalized() +
                                     (c[k] - c[(k + 3) % 4]).normalized();
    tag->corners[k] =
        ((c[k] + preprocessing.growth_px * outwards).array() + 0.5) /
            preprocessing.scale -
        0.5;
  }
}

}  // namespace

TagFamily GridFamily(const std::string& tag_family, int border_cells) {
  const bool is_wide = border_cells == 2;
  if (tag_family == "tag25h9")
    return is_wide ? TagFamily::k25h9WideBorder : TagFamily::k25h9;
  if (tag_family == "tag16h5")
    return is_wide ? TagFamily::k16h5WideBorder : TagFamily::k16h5;
  return is_wide ? TagFamily::k36h11WideBorder : TagFamily::k36h11;
}

std::vector<DetectedTag> FindGridTags(const GreyImage& image,
                                      const std::vector<TagFamily>& families,
                                      TagSearch search) {
  const cv::Mat grey = ReadableImage(image);
  const TagDetector detector(families, {});
  std::vector<DetectedTag> found;
  for (const Preprocessing& preprocessing : kPreprocessings) {
    if (preprocessing.scale > 1 &&
        static_cast<double>(grey.total()) > kMaxPixelsToEnlarge)
      continue;
    const bool is_quick =
        preprocessing.scale == 1 && preprocessing.growth_px < 2;
    if (search == TagSearch::kQuick && !is_quick) continue;
    const size_t num_before = found.size();
    for (DetectedTag& tag :
         detector.Detect(PreprocessImage(grey, preprocessing))) {
      if (std::any_of(found.begin(), found.begin() + num_before,
                      [&](const DetectedTag& f) {
                        return f.id == tag.id && f.family == tag.family;
                      }))
        continue;
      Undo(preprocessing, &tag);
      found.push_back(tag);
    }
  }
  return found;
}

struct AprilGridLocator::Data {
  explicit Data(const Board& b)
      : board(b),
        markers(BoardAppearance(b).markers()),
        points_m(b.NominalPoints()),
        growth(b) {
    if (board.tag_family.compare(0, 3, "tag") != 0)
      dictionary = BoardDictionary(markers, board.border_cells);
  }

  Board board;
  TagFamily family = GridFamily(board.tag_family, board.border_cells);
  cv::Ptr<cv::aruco::Dictionary> dictionary;  // ArUco dictionary; null for
                                              // AprilTags
  std::vector<PlacedMarker> markers;
  std::vector<Eigen::Vector3d> points_m;
  CornerGrowth growth;

  std::vector<DetectedTag> FindTags(const GreyImage& image,
                                    TagSearch search) const;
  std::vector<DetectedMarker> OnBoard(const std::vector<DetectedTag>& tags,
                                      int quarter_turns) const;
  MarkerConstellation Constellation(const std::vector<DetectedTag>& tags) const;
  void FindTagCorners(const GreyImage& image, const MarkerConstellation& tags,
                      const DetectedMarker& tag, FeatureLattice* lattice) const;
  std::pair<int, int> FirstFeature(const DetectedMarker& tag) const;
  void SetTagCorners(const DetectedMarker& tag, FeatureLattice* lattice) const;
  FeatureLattice FindCorners(const GreyImage& image,
                             const MarkerConstellation& tags) const;
  double pitch_m() const { return board.square_m * (1 + board.spacing_ratio); }
};

std::vector<DetectedTag> AprilGridLocator::Data::FindTags(
    const GreyImage& image, TagSearch search) const {
  if (!dictionary) return FindGridTags(image, {family}, search);
  std::vector<DetectedTag> tags;
  for (const DetectedMarker& marker :
       FindArucoMarkers(image, dictionary, board.border_cells))
    tags.push_back({family, markers[marker.index].id, marker.corners_px});
  return tags;
}

// Returns the board's tags, with corners rotated by multiples of 90 degrees.
std::vector<DetectedMarker> AprilGridLocator::Data::OnBoard(
    const std::vector<DetectedTag>& tags, int quarter_turns) const {
  std::vector<DetectedMarker> seen;
  for (const DetectedTag& tag : tags) {
    const auto place = std::find_if(
        markers.begin(), markers.end(),
        [&](const PlacedMarker& marker) { return marker.id == tag.id; });
    if (place == markers.end()) continue;
    DetectedMarker marker;
    marker.index = static_cast<int>(place - markers.begin());
    for (int k = 0; k < 4; ++k)
      marker.corners_px[k] = tag.corners[(k + quarter_turns) % 4];
    seen.push_back(marker);
  }
  return seen;
}

// Generators of boards use different upright directions of tags: chooses the
// rotation for which neighbouring tags are most consistent.
MarkerConstellation AprilGridLocator::Data::Constellation(
    const std::vector<DetectedTag>& tags) const {
  MarkerConstellation best(markers, pitch_m(), OnBoard(tags, 0));
  for (int quarter_turns = 1; quarter_turns < 4; ++quarter_turns) {
    const MarkerConstellation turned(markers, pitch_m(),
                                     OnBoard(tags, quarter_turns));
    if (turned.CountConsistent() > best.CountConsistent()) best = turned;
  }
  return best;
}

// Returns the column and row of a tag's top-left corner.
std::pair<int, int> AprilGridLocator::Data::FirstFeature(
    const DetectedMarker& tag) const {
  const Eigen::Vector2d place = markers[tag.index].corner / pitch_m();
  return {2 * static_cast<int>(std::lround(place.x())),
          2 * static_cast<int>(std::lround(place.y()))};
}

void AprilGridLocator::Data::FindTagCorners(const GreyImage& image,
                                            const MarkerConstellation& tags,
                                            const DetectedMarker& tag,
                                            FeatureLattice* lattice) const {
  const auto [left, top] = FirstFeature(tag);
  for (int row = top; row < top + 2; ++row) {
    for (int column = left; column < left + 2; ++column) {
      const Eigen::Vector2d corner_m =
          points_m[board.PointIndex(column, row)].head<2>();
      constexpr double kSearchSquares = 0.1;
      growth.Find(image, column, row,
                  tags.MappingAt(corner_m, board.square_m, {tag}),
                  kSearchSquares, {kMinCorrelations[0]}, lattice);
    }
  }
}

// Without corner squares, features are the corners of the tags' outlines. No
// others are searched, since corners of cells may look like them.
void AprilGridLocator::Data::SetTagCorners(const DetectedMarker& tag,
                                           FeatureLattice* lattice) const {
  const auto [left, top] = FirstFeature(tag);
  lattice->Set(left, top, tag.corners_px[0]);
  lattice->Set(left + 1, top, tag.corners_px[1]);
  lattice->Set(left + 1, top + 1, tag.corners_px[2]);
  lattice->Set(left, top + 1, tag.corners_px[3]);
}

FeatureLattice AprilGridLocator::Data::FindCorners(
    const GreyImage& image, const MarkerConstellation& tags) const {
  FeatureLattice lattice(board);
  if (!board.has_corner_squares) {
    for (const DetectedMarker& tag : tags.seen()) SetTagCorners(tag, &lattice);
    return lattice;
  }
  for (const DetectedMarker& tag : tags.seen())
    FindTagCorners(image, tags, tag, &lattice);
  for (const double min_correlation : kMinCorrelations)
    growth.Grow(image, {min_correlation}, &lattice);
  return lattice;
}

AprilGridLocator::AprilGridLocator(const Board& board)
    : data_(std::make_unique<Data>(board)) {}
AprilGridLocator::~AprilGridLocator() = default;

ImageDetection AprilGridLocator::Locate(const GreyImage& image) const {
  const std::vector<DetectedTag> tags =
      data_->FindTags(image, TagSearch::kThorough);
  const MarkerConstellation seen = data_->Constellation(tags);
  const MarkerConstellation fitting = seen.SelectConsistent();
  ImageDetection located;
  const FeatureLattice lattice = data_->FindCorners(image, fitting);
  located.features = lattice.Features();
  if (seen.size() > 0 && fitting.size() == 0)
    located.warnings.push_back(
        fmt::format("board {}: no two of the detected tags ({}) are consistent "
                    "with the layout of the board",
                    data_->board.id, seen.size()));
  if (seen.size() == 0 && !tags.empty())
    located.warnings.push_back(
        fmt::format("detected tag {} does not belong to board {}", tags[0].id,
                    data_->board.id));
  if (fitting.size() > 0 && lattice.num_found() == 0)
    located.warnings.push_back(fmt::format(
        "board {}: {} tags detected, but no black squares at their corners; if "
        "it has none, set 'corner_squares: false' (no-squares in a "
        "specification), 'border_cells' and 'numbered_from'",
        data_->board.id, fitting.size()));
  if (fitting.size() == 0 &&
      data_->Constellation(
               data_->FindTags(MirrorImage(image), TagSearch::kQuick))
              .SelectConsistent()
              .size() > 0)
    located.warnings.push_back(
        fmt::format("board {} is mirrored", data_->board.id));
  return located;
}

Locator MakeAprilGridLocator(const Board& board) {
  return [locator = std::make_shared<AprilGridLocator>(board)](
             const GreyImage& image) { return locator->Locate(image); };
}

}  // namespace raygrid
