#include "features/star_detection.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "features/feature_lattice.h"
#include "features/feature_refinement.h"
#include "features/matching_refinement.h"
#include "features/tag_detection.h"

namespace raygrid {
namespace {

constexpr double kMinSpacingPx = 6;
// The sure ones first: they tell where the others must be.
constexpr double kMinCorrelations[] = {0.7, 0.5, 0.35};
constexpr int kMinFeatures = 5;  // on a board, or it is not believed

// The corners of a tag's black square, clockwise from the top left, in squares.
std::array<Eigen::Vector2d, 4> CornersOnBoard(const BoardTag& tag) {
  const double cell = tag.squares / 10.0;
  const double x0 = tag.column + cell, x1 = tag.column + tag.squares - cell;
  const double y0 = tag.row + cell, y1 = tag.row + tag.squares - cell;
  return {Eigen::Vector2d(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}};
}

// From four correspondences.
std::optional<Eigen::Matrix3d> Homography(
    const std::array<Eigen::Vector2d, 4>& from,
    const std::array<Eigen::Vector2d, 4>& to) {
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int k = 0; k < 4; ++k) {
    const double x = from[k].x(), y = from[k].y();
    const double u = to[k].x(), v = to[k].y();
    a.row(2 * k) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    a.row(2 * k + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    b.segment<2>(2 * k) = to[k];
  }
  const Eigen::Matrix<double, 8, 1> h = a.fullPivLu().solve(b);
  if (!h.allFinite()) return std::nullopt;
  Eigen::Matrix3d homography;
  homography << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return homography;
}

// A homography as a mapping of offsets from a place; nothing where it does not
// reach, at the horizon and behind it.
std::optional<LocalMapping> MappingAt(const Eigen::Matrix3d& homography,
                                      const Eigen::Vector2d& place) {
  const Eigen::Vector3d origin = homography * place.homogeneous();
  constexpr double kMinDenominator = 0.2;
  if (origin.z() < kMinDenominator) return std::nullopt;
  LocalMapping mapping;
  mapping.center = origin.hnormalized();
  mapping.perspective = homography.block<1, 2>(2, 0).transpose() / origin.z();
  mapping.linear = homography.topLeftCorner<2, 2>() / origin.z() -
                   mapping.center * mapping.perspective.transpose();
  return mapping;
}

// A tag seen in the image.
struct Anchor {
  BoardTag tag;
  std::array<Eigen::Vector2d, 4> corners;
  Eigen::Matrix3d homography;
};

bool IsInside(const ImageSize& size, const Eigen::Vector2d& pixel,
              double margin) {
  return pixel.x() >= margin && pixel.y() >= margin &&
         pixel.x() <= size.width - 1 - margin &&
         pixel.y() <= size.height - 1 - margin;
}

// Whether the star's square lies in the image.
bool IsWhollyVisible(const ImageSize& size, const LocalMapping& mapping) {
  constexpr double kMarginPx = -0.5;
  for (const double u : {-0.5, 0.5})
    for (const double v : {-0.5, 0.5})
      if (!IsInside(size,
                    mapping.center + mapping.linear * Eigen::Vector2d(u, v),
                    kMarginPx))
        return false;
  return true;
}

// Finds the stars of one board, outwards from its tags.
class Growth {
 public:
  Growth(const GreyImage& image, const Board& board, const StarTexture& texture,
         const std::vector<SymmetryMask>& masks,
         const DetectionOptions& options, std::vector<Anchor> anchors)
      : image_(image),
        board_(board),
        texture_(texture),
        masks_(masks),
        options_(options),
        anchors_(std::move(anchors)),
        lattice_(board),
        tried_with_(board.num_points(), 0) {}

  void Run() {
    for (const double min_correlation : kMinCorrelations) {
      min_correlation_ = min_correlation;
      std::fill(tried_with_.begin(), tried_with_.end(), 0);
      if (lattice_.num_found() < kMinFeatures) Seed();
      while (Sweep()) {
      }
    }
  }
  const FeatureLattice& lattice() const { return lattice_; }
  std::vector<RejectedFeature> Rejected() const {
    std::vector<RejectedFeature> rejected;
    for (const auto& [feature, reason] : attempts_)
      if (!lattice_.Has(feature.second, feature.first))
        rejected.push_back(
            {{board_.id, feature.second, feature.first, reason.first},
             reason.second});
    return rejected;
  }

 private:
  // The stars around the tags: one square away from them.
  void Seed() {
    constexpr double kSeedSearchSquares = 0.3;
    for (const Anchor& anchor : anchors_) {
      const BoardTag& tag = anchor.tag;
      for (int row = tag.row - 1; row <= tag.row + tag.squares + 1; ++row) {
        for (int column = tag.column - 1;
             column <= tag.column + tag.squares + 1; ++column) {
          if (!lattice_.IsOnBoard(column, row) ||
              !board_.HasFeature(column, row) || lattice_.Has(column, row))
            continue;
          const auto mapping =
              MappingAt(anchor.homography, Eigen::Vector2d(column, row));
          if (mapping) Try(column, row, *mapping, kSeedSearchSquares);
        }
      }
    }
  }

  // One pass over the places beside found ones, those with the most neighbours
  // first; false if nothing was found.
  bool Sweep() {
    std::vector<std::array<int, 3>> candidates;
    for (int row = 0; row < board_.rows; ++row) {
      for (int column = 0; column < board_.columns; ++column) {
        if (lattice_.Has(column, row) || !board_.HasFeature(column, row))
          continue;
        const int count = lattice_.CountAround(column, row);
        if (count > tried_with_[board_.PointIndex(column, row)] &&
            HasDirectNeighbour(column, row))
          candidates.push_back({-count, row, column});
      }
    }
    std::sort(candidates.begin(), candidates.end());
    const int before = lattice_.num_found();
    for (const auto& [count, row, column] : candidates) {
      tried_with_[board_.PointIndex(column, row)] = -count;
      LocalMapping mapping;
      if (Predict(column, row, &mapping))
        Try(column, row, mapping, -count >= 8 ? 0.12 : 0.25);
    }
    return lattice_.num_found() > before;
  }

  bool HasDirectNeighbour(int column, int row) const {
    return lattice_.Has(column - 1, row) || lattice_.Has(column + 1, row) ||
           lattice_.Has(column, row - 1) || lattice_.Has(column, row + 1);
  }

  bool Predict(int column, int row, LocalMapping* mapping) const {
    std::vector<Correspondence> around = lattice_.Around(column, row, 2, false);
    if (around.size() < 6) around = lattice_.Around(column, row, 3, false);
    constexpr size_t kEnough = 8;
    constexpr double kTagReachSquares = 6, kTagWeight = 0.05;
    if (around.size() < kEnough) {
      for (const Anchor& anchor : anchors_) {
        const auto corners = CornersOnBoard(anchor.tag);
        for (int k = 0; k < 4; ++k) {
          const Eigen::Vector2d offset =
              corners[k] - Eigen::Vector2d(column, row);
          if (offset.norm() < kTagReachSquares)
            around.push_back({offset, anchor.corners[k], kTagWeight});
        }
      }
    }
    return FitLocalMapping(around, 2, mapping);
  }

  // Looks for a star within a part of a square around the prediction.
  void Try(int column, int row, const LocalMapping& mapping,
           double search_squares) {
    const auto refuse = [&](const char* reason) {
      attempts_[{row, column}] = {mapping.center, reason};
    };
    const double spacing_px = mapping.SpacingPx();
    if (!IsInside(image_.size, mapping.center, 0) ||
        !IsWhollyVisible(image_.size, mapping))
      return;  // nothing to be seen
    if (spacing_px < kMinSpacingPx) return refuse("too small");
    constexpr double kMaxSearchPx = 9;
    const double search_px =
        std::clamp(search_squares * spacing_px, 1.0, kMaxSearchPx);
    const MatchingResult match =
        MatchStar(image_, texture_, masks_[board_.PointIndex(column, row)],
                  mapping, options_.window_px, search_px);
    if (!match.is_converged)
      return refuse(match.factor < 0 ? "colours inverted" : "no star");
    if (match.correlation < min_correlation_) return refuse("unlike a star");
    if (IsTaken(column, row, match.center, spacing_px))
      return refuse("another star's place");
    lattice_.Set(column, row, match.center);
  }

  // Whether another star was found there.
  bool IsTaken(int column, int row, const Eigen::Vector2d& pixel,
               double spacing_px) const {
    constexpr double kMinDistance = 0.6;  // of the spacing
    for (const Correspondence& other : lattice_.Around(column, row, 3, false))
      if ((other.pixel - pixel).norm() < kMinDistance * spacing_px) return true;
    return false;
  }

  const GreyImage& image_;
  const Board& board_;
  const StarTexture& texture_;
  const std::vector<SymmetryMask>& masks_;
  const DetectionOptions& options_;
  std::vector<Anchor> anchors_;
  FeatureLattice lattice_;
  double min_correlation_ = 1;
  std::vector<int> tried_with_;  // how many neighbours, by place
  // By row and column: where a star was sought in vain, and why.
  std::map<std::pair<int, int>, std::pair<Eigen::Vector2d, std::string>>
      attempts_;
};

}  // namespace

struct StarDetector::Data {
  struct StarBoard {
    Board board;
    StarTexture texture;
    std::vector<SymmetryMask> masks;
    FeatureRefiner refiner;
  };
  std::vector<std::unique_ptr<StarBoard>> boards;
  DetectionOptions options;
};

StarDetector::StarDetector(const Pattern& pattern,
                           const DetectionOptions& options)
    : data_(new Data) {
  data_->options = options;
  for (const Board& board : pattern.boards)
    if (board.kind == "star")
      data_->boards.emplace_back(new Data::StarBoard{
          board, StarTexture(board.segments), SymmetryMask::OfBoard(board),
          FeatureRefiner(board, options)});
}
StarDetector::~StarDetector() = default;

ImageDetection StarDetector::Detect(const GreyImage& image) const {
  ImageDetection detection;
  const std::vector<DetectedTag> tags = DetectTags(image);
  if (tags.empty()) {
    for (const std::string& seen : DescribeOtherTags(image))
      detection.remarks.push_back("no tag of the pattern, but " + seen);
    return detection;
  }
  std::vector<char> is_known(tags.size(), 0);
  for (const auto& star : data_->boards) {
    std::vector<Anchor> anchors;
    for (size_t i = 0; i < tags.size(); ++i) {
      for (const BoardTag& tag : star->board.tags) {
        if (tag.id != tags[i].id) continue;
        is_known[i] = 1;
        const auto homography =
            Homography(CornersOnBoard(tag), tags[i].corners);
        if (homography) anchors.push_back({tag, tags[i].corners, *homography});
      }
    }
    if (anchors.empty()) continue;
    Growth growth(image, star->board, star->texture, star->masks,
                  data_->options, std::move(anchors));
    growth.Run();
    ImageDetection found =
        star->refiner.Refine(image, growth.lattice().Features());
    for (const RejectedFeature& rejected : growth.Rejected())
      detection.rejected.push_back(rejected);
    detection.rejected.insert(detection.rejected.end(), found.rejected.begin(),
                              found.rejected.end());
    if (found.features.size() < kMinFeatures) {
      detection.remarks.push_back(
          fmt::format("board {}: its tag is seen, but fewer than {} stars",
                      star->board.id, kMinFeatures));
      continue;
    }
    detection.features.insert(detection.features.end(), found.features.begin(),
                              found.features.end());
  }
  for (size_t i = 0; i < tags.size(); ++i)
    if (!is_known[i])
      detection.remarks.push_back(
          fmt::format("tag {} is on no board of the pattern", tags[i].id));
  return detection;
}

}  // namespace raygrid
