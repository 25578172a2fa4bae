#include "features/star/star_growth.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

namespace raygrid {
namespace {

// Minimum spacing of stars: below it, segments are not resolved, and rows are
// confused with adjacent ones.
constexpr double kMinStarSpacingPx = 8;
constexpr double kMaxSearchPx = 9;
// Maximum downscaling factor when the search radius exceeds kMaxSearchPx.
constexpr double kMinScale = 8;

// Computes the homography from four correspondences, scaled such that its
// denominator is 1 at the centre of `from`.
std::optional<Eigen::Matrix3d> Homography(
    const std::array<Eigen::Vector2d, 4>& from,
    const std::array<Eigen::Vector2d, 4>& to) {
  const Eigen::Vector2d center = (from[0] + from[1] + from[2] + from[3]) / 4;
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int k = 0; k < 4; ++k) {
    const double x = from[k].x() - center.x(), y = from[k].y() - center.y();
    const double u = to[k].x(), v = to[k].y();
    a.row(2 * k) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    a.row(2 * k + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    b.segment<2>(2 * k) = to[k];
  }
  const Eigen::Matrix<double, 8, 1> h = a.fullPivLu().solve(b);
  if (!h.allFinite()) return std::nullopt;
  Eigen::Matrix3d homography;
  homography << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  Eigen::Matrix3d from_center = Eigen::Matrix3d::Identity();
  from_center.topRightCorner<2, 1>() = -center;
  return homography * from_center;
}

// Converts a homography to a local mapping around a position; nullopt near or
// behind the horizon.
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

bool IsInside(const ImageSize& size, const Eigen::Vector2d& pixel,
              double margin) {
  return pixel.x() >= margin && pixel.y() >= margin &&
         pixel.x() <= size.width - 1 - margin &&
         pixel.y() <= size.height - 1 - margin;
}

// Whether a star's square, clipped to reach_px in each direction, lies within
// the image extended by slack_px on each side.
bool IsVisible(const ImageSize& size, const LocalMapping& mapping,
               double reach_px, double slack_px) {
  constexpr double kMarginPx = -0.5;
  for (const double u : {-0.5, 0.5}) {
    for (const double v : {-0.5, 0.5}) {
      const Eigen::Vector2d corner = mapping.linear * Eigen::Vector2d(u, v);
      const Eigen::Vector2d pixel =
          mapping.center + corner.cwiseMax(-reach_px).cwiseMin(reach_px);
      if (!IsInside(size, pixel, kMarginPx - slack_px)) return false;
    }
  }
  return true;
}

}  // namespace

std::array<Eigen::Vector2d, 4> CornersOnBoard(const BoardTag& tag) {
  const double cell = tag.squares / 10.0;
  const double x0 = tag.column + cell, x1 = tag.column + tag.squares - cell;
  const double y0 = tag.row + cell, y1 = tag.row + tag.squares - cell;
  return {Eigen::Vector2d(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}};
}

std::vector<VisibleTag> FindVisibleTags(
    const Board& board, const std::vector<DetectedTag>& detected) {
  std::vector<VisibleTag> seen;
  for (const DetectedTag& found : detected) {
    for (const BoardTag& tag : board.tags) {
      if (tag.id != found.id) continue;
      const auto homography = Homography(CornersOnBoard(tag), found.corners);
      if (homography) seen.push_back({tag, found.corners, *homography});
    }
  }
  return seen;
}

StarGrowth::StarGrowth(const GreyImage& image, const Board& board,
                       const StarTexture& texture,
                       const std::vector<SymmetryMask>& masks,
                       const DetectionOptions& options,
                       std::vector<VisibleTag> tags)
    : image_(image),
      board_(board),
      texture_(texture),
      masks_(masks),
      options_(options),
      tags_(std::move(tags)),
      lattice_(board),
      correlations_(board.num_points(), 0),
      num_neighbors_at_last_attempt_(board.num_points(), 0) {}

void StarGrowth::Grow() {
  // Reliable stars first, so that they predict the positions of the others.
  for (const double min_correlation : {0.7, 0.5, 0.35}) {
    std::fill(num_neighbors_at_last_attempt_.begin(),
              num_neighbors_at_last_attempt_.end(), -1);
    for (const VisibleTag& seen : tags_)
      if (lattice_.num_found() < kMinStarsOnBoard || !HasAdjacentStar(seen.tag))
        StartAtNeighbour(seen, min_correlation);
    while (Sweep(min_correlation)) {
    }
  }
}

void StarGrowth::GrowAcrossGaps() {
  constexpr double kMinGapCorrelation = 0.5;
  const auto lens = LatticeCamera::Fit(lattice_.Features(), image_.size);
  if (!lens || !TryWithCamera(*lens, kMinGapCorrelation)) return;
  while (Sweep(kMinGapCorrelation)) {
  }
}

// Searches stars that have no direct neighbours, at the positions predicted by
// the lens model; returns false if none was found.
bool StarGrowth::TryWithCamera(const LatticeCamera& lens,
                               double min_correlation) {
  constexpr double kSearchSquares = 0.1;
  const int before = lattice_.num_found();
  for (int row = 0; row < board_.rows; ++row) {
    for (int column = 0; column < board_.columns; ++column) {
      if (lattice_.Has(column, row) || !board_.HasFeature(column, row) ||
          HasDirectNeighbour(column, row))
        continue;
      const auto mapping = lens.Around(Eigen::Vector2d(column, row));
      if (mapping) Try(column, row, *mapping, kSearchSquares, min_correlation);
    }
  }
  return lattice_.num_found() > before;
}

bool StarGrowth::Agrees(const VisibleTag& seen) const {
  constexpr int kReach = 2;
  constexpr double kMaxError = 0.5;  // squares
  const std::array<Eigen::Vector2d, 4> corners = CornersOnBoard(seen.tag);
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2i place = corners[k].array().round().cast<int>();
    LocalMapping mapping;
    if (FitLocalMapping(lattice_.Around(place.x(), place.y(), kReach, true), 1,
                        &mapping) == 0)
      continue;
    const Eigen::Vector2d error =
        mapping(corners[k] - place.cast<double>()) - seen.corners[k];
    if (error.norm() > kMaxError * mapping.SpacingPx()) return false;
  }
  return true;
}

bool StarGrowth::AgreesWithTags() const {
  return std::all_of(tags_.begin(), tags_.end(),
                     [&](const VisibleTag& seen) { return Agrees(seen); });
}

bool StarGrowth::HasFewFailures(double max_in_vain) const {
  return lattice_.num_found() >= kMinStarsOnBoard &&
         ListRejected().size() <= max_in_vain * lattice_.num_found();
}

std::vector<RejectedFeature> StarGrowth::ListRejected() const {
  std::vector<RejectedFeature> rejected;
  for (const auto& [feature, reason] : last_attempts_)
    if (!lattice_.Has(feature.second, feature.first))
      rejected.push_back(
          {{board_.id, feature.second, feature.first, reason.first},
           reason.second});
  return rejected;
}

bool StarGrowth::HasAdjacentStar(const BoardTag& tag) const {
  for (int row = tag.row - 1; row <= tag.row + tag.squares + 1; ++row)
    for (int column = tag.column - 1; column <= tag.column + tag.squares + 1;
         ++column)
      if (lattice_.Has(column, row)) return true;
  return false;
}

// Adds only the star with the highest correlation around a tag, at most one
// square away. The others are found from it: with a fisheye, the tag's
// homography may predict them poorly.
void StarGrowth::StartAtNeighbour(const VisibleTag& seen,
                                  double min_correlation) {
  constexpr double kSearchSquares = 0.3;
  const BoardTag& tag = seen.tag;
  double best_correlation = 0;
  std::pair<int, int> best;  // column, row
  Eigen::Vector2d best_pixel;
  for (int row = tag.row - 1; row <= tag.row + tag.squares + 1; ++row) {
    for (int column = tag.column - 1; column <= tag.column + tag.squares + 1;
         ++column) {
      if (!lattice_.IsOnBoard(column, row) || !board_.HasFeature(column, row) ||
          lattice_.Has(column, row))
        continue;
      const auto mapping =
          MappingAt(seen.homography, Eigen::Vector2d(column, row));
      if (!mapping ||
          !Try(column, row, *mapping, kSearchSquares, min_correlation))
        continue;
      const double correlation = correlations_[board_.PointIndex(column, row)];
      if (correlation > best_correlation) {
        best_correlation = correlation;
        best = {column, row};
        best_pixel = lattice_.at(column, row);
      }
      lattice_.Remove(column, row);
    }
  }
  if (best_correlation == 0) return;
  lattice_.Set(best.first, best.second, best_pixel);
  correlations_[board_.PointIndex(best.first, best.second)] = best_correlation;
}

// One pass over the undetected features next to detected ones, in descending
// order of the number of neighbours; returns false if none was found.
bool StarGrowth::Sweep(double min_correlation) {
  std::vector<std::array<int, 3>> candidates;
  for (int row = 0; row < board_.rows; ++row) {
    for (int column = 0; column < board_.columns; ++column) {
      if (lattice_.Has(column, row) || !board_.HasFeature(column, row) ||
          !(HasDirectNeighbour(column, row) || IsAdjacentToTag(column, row)))
        continue;
      const int count = lattice_.CountNeighbours(column, row);
      if (count >
          num_neighbors_at_last_attempt_[board_.PointIndex(column, row)])
        candidates.push_back({-count, row, column});
    }
  }
  std::sort(candidates.begin(), candidates.end());
  const int before = lattice_.num_found();
  for (const auto& [count, row, column] : candidates) {
    num_neighbors_at_last_attempt_[board_.PointIndex(column, row)] = -count;
    LocalMapping mapping;
    if (Predict(column, row, &mapping) &&
        Try(column, row, mapping, -count >= 8 ? 0.12 : 0.25, min_correlation))
      continue;
    constexpr double kElsewhere = 0.05;  // squares
    LocalMapping other;
    if (FitPerspectiveMapping(lattice_.Around(column, row, 2, false), 2,
                              &other) &&
        (other.center - mapping.center).norm() >
            kElsewhere * other.SpacingPx() &&
        Try(column, row, other, 0.12, min_correlation))
      continue;
    // Between a tag and the board's edge there are only one or two rows of
    // stars.
    constexpr int kFew = 10;
    if (-count <= kFew &&
        PredictFromTag(column, row, lattice_.Around(column, row, 3, false),
                       &mapping))
      Try(column, row, mapping, 0.25, min_correlation);
  }
  return lattice_.num_found() > before;
}

// Whether a feature is adjacent to a detected tag, whose homography predicts
// it.
bool StarGrowth::IsAdjacentToTag(int column, int row) const {
  return std::any_of(tags_.begin(), tags_.end(), [&](const VisibleTag& seen) {
    const BoardTag& tag = seen.tag;
    return column >= tag.column - 1 && row >= tag.row - 1 &&
           column <= tag.column + tag.squares + 1 &&
           row <= tag.row + tag.squares + 1;
  });
}

bool StarGrowth::HasDirectNeighbour(int column, int row) const {
  return lattice_.Has(column - 1, row) || lattice_.Has(column + 1, row) ||
         lattice_.Has(column, row - 1) || lattice_.Has(column, row + 1);
}

bool StarGrowth::Predict(int column, int row, LocalMapping* mapping) const {
  std::vector<Correspondence> around = lattice_.Around(column, row, 2, false);
  if (around.size() < 6) around = lattice_.Around(column, row, 3, false);
  constexpr size_t kMinNeighborsWithoutTag = 4;
  if (around.size() < kMinNeighborsWithoutTag &&
      PredictFromTag(column, row, around, mapping))
    return true;
  return FitLocalMapping(around, 2, mapping) > 0 ||
         PredictFromTag(column, row, around, mapping);
}

// Predicts a star with the homography of the nearest tag, corrected by the
// prediction error at the nearest detected star, if any.
bool StarGrowth::PredictFromTag(int column, int row,
                                const std::vector<Correspondence>& around,
                                LocalMapping* mapping) const {
  const Eigen::Vector2d place(column, row);
  double min_distance = 6;  // squares
  bool is_predicted = false;
  for (const VisibleTag& seen : tags_) {
    const double half = seen.tag.squares / 2.0;
    const Eigen::Vector2d center(seen.tag.column + half, seen.tag.row + half);
    const double distance = (center - place).norm();
    const auto predicted = MappingAt(seen.homography, place);
    if (distance > min_distance || !predicted) continue;
    LocalMapping moved = *predicted;
    if (!around.empty()) {
      const Correspondence& star = *std::min_element(
          around.begin(), around.end(),
          [](const Correspondence& a, const Correspondence& b) {
            return a.offset.norm() < b.offset.norm();
          });
      const auto at_star = MappingAt(seen.homography, place + star.offset);
      if (!at_star) continue;
      moved.center += star.pixel - at_star->center;
    }
    *mapping = moved;
    min_distance = distance;
    is_predicted = true;
  }
  return is_predicted;
}

bool StarGrowth::Try(int column, int row, const LocalMapping& mapping,
                     double search_squares, double min_correlation) {
  const double spacing_px = mapping.SpacingPx();
  const double search_px =
      std::min(search_squares * spacing_px, kMaxSearchPx * kMinScale);
  // Only the part of a star within the window must be in the image.
  const double window_radius_px = options_.window_px / 2;
  if (!IsVisible(image_.size, mapping, window_radius_px, search_px))
    return false;  // star outside the image
  const auto refuse = [&](const char* reason) {
    // Stars that the image's edge may hide do not count as unsuccessful
    // searches.
    if (IsVisible(image_.size, mapping, INFINITY, 0))
      last_attempts_[{row, column}] = {mapping.center, reason};
    return false;
  };
  if (!(spacing_px >= kMinStarSpacingPx)) return refuse("too small");
  const SymmetryMask& mask =
      masks_.size() == 1 ? masks_[0] : masks_[board_.PointIndex(column, row)];
  const MatchingResult match = Match(mask, mapping, search_px);
  if (!match.is_converged)
    return refuse(match.factor < 0 ? "colours inverted" : "no star");
  if (match.correlation <
      std::max(min_correlation,
               min_correlation_ratio_ * CorrelationAround(column, row)))
    return refuse("does not match a star");
  LocalMapping found = mapping;
  found.center = match.center;
  if (!IsVisible(image_.size, mapping, window_radius_px, 0) &&
      !IsVisible(image_.size, found, window_radius_px, 0))
    return false;
  if (IsOccupied(column, row, match.center, mapping) ||
      IsFolded(column, row, match.center))
    return refuse("duplicate of another star");
  lattice_.Set(column, row, match.center);
  correlations_[board_.PointIndex(column, row)] = match.correlation;
  return true;
}

// If the search radius is large, searches in a downscaled image first, in which
// the window covers more of the star.
MatchingResult StarGrowth::Match(const SymmetryMask& mask,
                                 const LocalMapping& mapping,
                                 double search_px) {
  constexpr double kSurely = 0.7;
  const MatchingResult near =
      MatchStar(image_, texture_, mask, mapping, options_.window_px,
                std::clamp(search_px, 1.0, kMaxSearchPx));
  if (search_px <= kMaxSearchPx ||
      (near.is_converged && near.correlation >= kSurely))
    return near;
  int level = 0;
  double scale = 1;
  while (search_px > kMaxSearchPx * scale) {
    ++level;
    scale *= 2;
  }
  LocalMapping smaller = mapping;
  smaller.center = ToDownscaled(mapping.center, scale);
  smaller.linear /= scale;
  const MatchingResult rough =
      MatchStar(GetDownscaledImage(level), texture_, mask, smaller,
                options_.window_px, search_px / scale);
  if (!rough.is_converged) return near;
  LocalMapping moved = mapping;
  moved.center = FromDownscaled(rough.center, scale);
  const MatchingResult far =
      MatchStar(image_, texture_, mask, moved, options_.window_px, 1 + scale);
  return far.is_converged && far.correlation > near.correlation ? far : near;
}

// Returns the image halved `level` times.
const GreyImage& StarGrowth::GetDownscaledImage(int level) {
  while (static_cast<int>(downscaled_images_.size()) < level)
    downscaled_images_.push_back(HalveImage(
        downscaled_images_.empty() ? image_ : downscaled_images_.back()));
  return downscaled_images_[level - 1];
}

// Returns the mean correlation of the detected neighbours; 0 if there are none.
double StarGrowth::CorrelationAround(int column, int row) const {
  double sum = 0;
  int count = 0;
  for (int r = row - 1; r <= row + 1; ++r) {
    for (int c = column - 1; c <= column + 1; ++c) {
      if (!lattice_.Has(c, r)) continue;
      sum += correlations_[board_.PointIndex(c, r)];
      ++count;
    }
  }
  return sum / std::max(1, count);
}

// Whether another star was detected near the pixel. With sheared squares, a
// diagonal neighbour may be closer than the next one in the row.
bool StarGrowth::IsOccupied(int column, int row, const Eigen::Vector2d& pixel,
                            const LocalMapping& mapping) const {
  constexpr double kMinDistance = 0.6;  // fraction of the expected distance
  for (const Correspondence& other : lattice_.Around(column, row, 3, false)) {
    const double expected_px =
        std::min(mapping.SpacingPx(), (mapping.linear * other.offset).norm());
    if ((other.pixel - pixel).norm() < kMinDistance * expected_px) return true;
  }
  return false;
}

// Whether the step from the previous star in a row or column is reversed or
// much shorter than the step before: an extrapolated polynomial may fold.
bool StarGrowth::IsFolded(int column, int row,
                          const Eigen::Vector2d& pixel) const {
  constexpr double kMinPart = 0.3;  // fraction of the previous step
  for (const auto& [u, v] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    if (!lattice_.Has(column + u, row + v) ||
        !lattice_.Has(column + 2 * u, row + 2 * v))
      continue;
    const Eigen::Vector2d& last = lattice_.at(column + u, row + v);
    const Eigen::Vector2d before =
        last - lattice_.at(column + 2 * u, row + 2 * v);
    if ((pixel - last).dot(before) < kMinPart * before.squaredNorm())
      return true;
  }
  return false;
}

}  // namespace raygrid
