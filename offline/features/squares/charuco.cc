#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "features/board_view/locators.h"
#include "features/squares/aruco_markers.h"
#include "features/squares/corner_growth.h"
#include "features/squares/detected_markers.h"

namespace raygrid {

/// Detects the chessboard corners of a ChArUco board approximately: predicts
/// each corner adjacent to a marker with a homography fitted to the nearest
/// markers, then extends the lattice from these corners.
class CharucoLocator {
 public:
  explicit CharucoLocator(const Board& board);
  ~CharucoLocator();

  /// Markers may have OpenCV's current layout or that of versions before 4.6:
  /// if the layout in the pattern fits worse than the other, uses the other and
  /// warns.
  ImageDetection Locate(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

namespace {

// Distances in squares: a corner is 0.71 from the centre of adjacent markers,
// and 1.58 from the next ones.
constexpr double kAdjacentDistance = 1;
constexpr double kNearDistance = 2.3;
constexpr int kMaxNearMarkers = 4;
constexpr int kBorderCells = 1;

Board MakeAlternativeLayout(Board board) {
  board.is_legacy = !board.is_legacy;
  return board;
}

// The layouts differ only if the number of rows of squares is even.
bool HasAlternativeLayout(const Board& board) {
  return (board.rows + 1) % 2 == 0;
}

}  // namespace

struct CharucoLocator::Data {
  explicit Data(const Board& b)
      : board(b),
        markers(BoardAppearance(b).markers()),
        alternative_markers(
            BoardAppearance(MakeAlternativeLayout(b)).markers()),
        dictionary(BoardDictionary(markers, kBorderCells)),
        growth(b),
        alternative_growth(MakeAlternativeLayout(b)) {}

  Board board;
  std::vector<PlacedMarker> markers, alternative_markers;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  CornerGrowth growth, alternative_growth;

  std::vector<DetectedMarker> FindMarkers(const GreyImage& image) const {
    return FindArucoMarkers(image, dictionary, kBorderCells);
  }
  FeatureLattice FindCorners(const GreyImage& image,
                             const MarkerConstellation& markers,
                             const CornerGrowth& drawn) const;
  int NumConsistentMarkers(const GreyImage& image) const;
  double pitch_m() const { return M_SQRT2 * board.square_m; }
};

int CharucoLocator::Data::NumConsistentMarkers(const GreyImage& image) const {
  return MarkerConstellation(markers, pitch_m(), FindMarkers(image))
      .SelectConsistent()
      .size();
}

// Detects the corners adjacent to markers first, then extends the lattice.
FeatureLattice CharucoLocator::Data::FindCorners(
    const GreyImage& image, const MarkerConstellation& constellation,
    const CornerGrowth& drawn) const {
  FeatureLattice lattice(board);
  constexpr double kMarkerCorrelations[] = {0.7, 0.6};
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const Eigen::Vector2d corner_m(column * board.square_m,
                                     row * board.square_m);
      const std::vector<DetectedMarker> near = constellation.FindNearest(
          corner_m, kNearDistance * board.square_m, kMaxNearMarkers);
      if (near.empty() || constellation.Distance(near[0], corner_m) >
                              kAdjacentDistance * board.square_m)
        continue;
      constexpr double kSearchSquares = 0.15;
      drawn.Find(image, column, row,
                 constellation.MappingAt(corner_m, board.square_m, near),
                 kSearchSquares, {kMarkerCorrelations[0]}, &lattice);
    }
  }
  for (const double min_correlation : kMarkerCorrelations)
    drawn.Grow(image, {min_correlation}, &lattice);
  drawn.GrowWithSpacingRatio(image, {0.7, 0.9}, &lattice);
  return lattice;
}

CharucoLocator::CharucoLocator(const Board& board)
    : data_(std::make_unique<Data>(board)) {}
CharucoLocator::~CharucoLocator() = default;

ImageDetection CharucoLocator::Locate(const GreyImage& image) const {
  const Board& board = data_->board;
  const std::vector<DetectedMarker> seen = data_->FindMarkers(image);
  ImageDetection located;
  MarkerConstellation markers(data_->markers, data_->pitch_m(), seen);
  bool is_other = false;
  if (HasAlternativeLayout(board)) {
    const MarkerConstellation other(data_->alternative_markers,
                                    data_->pitch_m(), seen);
    is_other = other.CountConsistent() > std::max(0, markers.CountConsistent());
    if (is_other) {
      markers = other;
      located.warnings.push_back(fmt::format(
          "board {}: its markers are laid out as in {}; set 'legacy: {}' in "
          "the pattern",
          board.id,
          board.is_legacy ? "OpenCV 4.6 and later" : "OpenCV before 4.6",
          !board.is_legacy));
    }
  }
  const int num_seen = markers.size();
  markers = markers.SelectConsistent();
  if (num_seen > 0 && markers.size() == 0)
    located.warnings.push_back(
        fmt::format("board {}: no two of the detected markers ({}) are "
                    "consistent with the layout of the board",
                    board.id, num_seen));
  located.features =
      data_
          ->FindCorners(image, markers,
                        is_other ? data_->alternative_growth : data_->growth)
          .Features();
  constexpr int kMinMarkersForOrientation = 4;
  if (markers.size() < kMinMarkersForOrientation &&
      data_->NumConsistentMarkers(MirrorImage(image)) > markers.size()) {
    located.warnings.push_back(fmt::format("board {} is mirrored", board.id));
    located.features.clear();  // ambiguous corners with arbitrary numbers
  }
  return located;
}

Locator MakeCharucoLocator(const Board& board) {
  return [locator = std::make_shared<CharucoLocator>(board)](
             const GreyImage& image) { return locator->Locate(image); };
}

}  // namespace raygrid
