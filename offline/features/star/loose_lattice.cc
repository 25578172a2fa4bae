#include "features/star/loose_lattice.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

namespace raygrid {
namespace {

constexpr double kMinCorrelation = 0.5;
constexpr int kMinStars = 12;   // minimum size of an accepted lattice
constexpr int kMaxTrials = 40;  // number of candidates
constexpr size_t kNumNearestStars = 12, kNumNeighbors = 40;
// Stars of few segments have junctions along the edges of their squares too.
constexpr int kMaxFewSegments = 6, kMoreJunctions = 2;

Board LooseBoard(int segments, int side) {
  Board board;
  board.kind = "star";
  board.columns = board.rows = side;
  board.square_m = 1;
  board.segments = segments;
  return board;
}

// Columns: offsets in pixels to the next star to the right and to the one
// below.
using Basis = Eigen::Matrix2d;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Returns the offsets from a position to the surrounding candidates, nearest
// first.
std::vector<Eigen::Vector2d> OffsetsAround(
    const std::vector<StarCandidate>& candidates, const Eigen::Vector2d& center,
    size_t max_count) {
  constexpr double kSamePx = 3;
  std::vector<Eigen::Vector2d> offsets;
  for (const StarCandidate& candidate : candidates)
    if ((candidate.pixel - center).norm() > kSamePx)
      offsets.push_back(candidate.pixel - center);
  const auto is_nearer = [](const Eigen::Vector2d& a,
                            const Eigen::Vector2d& b) {
    return a.squaredNorm() < b.squaredNorm();
  };
  const size_t count = std::min(max_count, offsets.size());
  std::partial_sort(offsets.begin(), offsets.begin() + count, offsets.end(),
                    is_nearer);
  offsets.resize(count);
  return offsets;
}

// Returns the number of the eight neighbours that coincide with candidates.
int Support(const Basis& linear, const std::vector<Eigen::Vector2d>& offsets) {
  constexpr double kTolerance = 0.2;
  const double tolerance_px =
      kTolerance * std::min(linear.col(0).norm(), linear.col(1).norm());
  int support = 0;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u)
      support += (u != 0 || v != 0) &&
                 std::any_of(
                     offsets.begin(), offsets.end(),
                     [&](const Eigen::Vector2d& offset) {
                       return (offset - linear * Eigen::Vector2d(u, v)).norm() <
                              tolerance_px;
                     });
  return support;
}

// Returns pairs of neighbours that span a lattice on which there are other
// candidates, in ascending order of the cell area.
std::vector<Basis> FindBases(const std::vector<Eigen::Vector2d>& offsets,
                             size_t num_nearest) {
  constexpr double kMinSine = 0.4, kMaxStretch = 5;
  constexpr int kMinSupport = 4;
  const size_t count = std::min(num_nearest, offsets.size());
  std::vector<Basis> bases;
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) {
      const Eigen::Vector2d &a = offsets[i], &b = offsets[j];
      // Bases that differ by a rotation of 90 degrees are equivalent.
      if (a.x() <= std::abs(b.x())) continue;
      const double product = a.norm() * b.norm();
      if (Cross(a, b) < kMinSine * product ||
          a.norm() > kMaxStretch * b.norm() ||
          b.norm() > kMaxStretch * a.norm())
        continue;
      Basis basis;
      basis << a, b;
      if (Support(basis, offsets) >= kMinSupport) bases.push_back(basis);
    }
  }
  std::stable_sort(bases.begin(), bases.end(),
                   [](const Basis& a, const Basis& b) {
                     return a.determinant() < b.determinant();
                   });
  return bases;
}

Basis RotateByQuarter(const Basis& linear) {
  Basis turned;
  turned << linear.col(1), -linear.col(0);
  return turned;
}

LocalMapping ShiftMapping(LocalMapping mapping, const Eigen::Vector2d& offset) {
  mapping.center += mapping.linear * offset;
  return mapping;
}

}  // namespace

int CountStarSymmetries(int segments) {
  return segments % 8 == 0 ? 4 : segments % 4 == 0 ? 2 : 1;
}

LooseLatticeFinder::LooseLatticeFinder(int segments, int max_side,
                                       const DetectionOptions& options)
    : board_(LooseBoard(segments, 2 * max_side + 1)),
      texture_(segments),
      masks_(SymmetryMask::MakeBoardMasks(LooseBoard(segments, 1))),
      options_(options) {}

// Returns the basis that maximizes the summed correlation of a star and its
// four neighbours; nullopt if too low.
std::optional<LooseLatticeFinder::Seed> LooseLatticeFinder::SeedAt(
    const GreyImage& image, const std::vector<StarCandidate>& candidates,
    const Eigen::Vector2d& center) const {
  constexpr double kMinTotalGain = 0.3;
  constexpr double kMinTotal = 3 * kMinCorrelation;
  std::optional<Seed> best;
  const auto correlation = [&](const LocalMapping& mapping, double search_px) {
    const MatchingResult match = MatchStar(image, texture_, masks_[0], mapping,
                                           options_.window_px, search_px);
    return match.is_converged ? match.correlation : 0;
  };
  const int num_rotations = 4 / CountStarSymmetries(board_.segments);
  const int density = board_.segments <= kMaxFewSegments ? kMoreJunctions : 1;
  const auto offsets =
      OffsetsAround(candidates, center, density * kNumNeighbors);
  for (const Basis& basis : FindBases(offsets, density * kNumNearestStars)) {
    LocalMapping mapping;
    mapping.center = center;
    mapping.linear = basis;
    for (int turn = 0; turn < num_rotations; ++turn) {
      double total = correlation(mapping, 1);
      if (total >= kMinCorrelation) {
        const double search_px = std::max(2.0, 0.15 * mapping.SpacingPx());
        for (const Eigen::Vector2d& offset :
             {Eigen::Vector2d(1, 0), {-1, 0}, {0, 1}, {0, -1}})
          total += correlation(ShiftMapping(mapping, offset), search_px);
        if (total > (best ? best->total + kMinTotalGain : kMinTotal))
          best = Seed{mapping, total};
      }
      mapping.linear = RotateByQuarter(mapping.linear);
    }
  }
  return best;
}

// Returns up to kMaxSeeds seeds in descending order of the correlation; removes
// the candidates that were tried.
std::vector<LooseLatticeFinder::Seed> LooseLatticeFinder::FindSeeds(
    const GreyImage& smaller, double scale,
    std::vector<StarCandidate>* candidates) const {
  constexpr size_t kMaxSeeds = 4;
  std::vector<StarCandidate> all = *candidates;
  for (StarCandidate& candidate : all)
    candidate.pixel = ToDownscaled(candidate.pixel, scale);
  std::vector<Seed> seeds;
  // In random order, because corners of squares may all have less scatter than
  // the stars.
  std::mt19937 random(1);
  for (int trial = 0;
       trial < kMaxTrials && !candidates->empty() && seeds.size() < kMaxSeeds;
       ++trial) {
    const auto chosen = candidates->begin() + random() % candidates->size();
    const auto seed = SeedAt(smaller, all, ToDownscaled(chosen->pixel, scale));
    if (seed) seeds.push_back(*seed);
    candidates->erase(chosen);
  }
  std::stable_sort(
      seeds.begin(), seeds.end(),
      [](const Seed& a, const Seed& b) { return a.total > b.total; });
  return seeds;
}

// Stars of four segments form a chessboard, in which the corners of squares,
// and after a rotation of 90 degrees the midpoints of their sides, also match a
// star.
std::vector<LooseLatticeFinder::Seed> LooseLatticeFinder::FindSimilarStars(
    const Seed& seed) const {
  if (board_.segments != 4) return {};
  std::vector<Seed> others(3, seed);
  others[0].mapping = ShiftMapping(seed.mapping, {0.5, 0.5});
  others[1].mapping = ShiftMapping(seed.mapping, {0.5, 0});
  others[2].mapping = ShiftMapping(seed.mapping, {0, 0.5});
  for (const int turned : {1, 2})
    others[turned].mapping.linear = RotateByQuarter(seed.mapping.linear);
  return others;
}

FeatureLattice LooseLatticeFinder::GrowFrom(const GreyImage& image,
                                            const Seed& seed,
                                            double alike) const {
  const int mid = board_.columns / 2;
  StarGrowth growth(image, board_, texture_, masks_, options_, {});
  growth.SetMinCorrelationRatio(alike);
  for (int row = -1; row <= 1; ++row)
    for (int column = -1; column <= 1; ++column)
      growth.Try(mid + column, mid + row,
                 ShiftMapping(seed.mapping, Eigen::Vector2d(column, row)), 0.2,
                 kMinCorrelation);
  growth.Grow();
  return growth.lattice();
}

std::vector<FeatureLattice> LooseLatticeFinder::Find(
    const GreyImage& image, const GreyImage& smaller, double scale,
    std::vector<StarCandidate>* candidates) const {
  // Half stars along the board's edges correlate less than their neighbours, as
  // do stars where the resolution decreases.
  constexpr double kMinCorrelationRatio = 0.6,
                   kMinReducedCorrelationRatio = 0.5;
  for (Seed seed : FindSeeds(smaller, scale, candidates)) {
    seed.mapping.center = FromDownscaled(seed.mapping.center, scale);
    seed.mapping.linear *= scale;
    std::vector<FeatureLattice> lattices = {
        GrowFrom(image, seed, kMinCorrelationRatio),
        GrowFrom(image, seed, kMinReducedCorrelationRatio)};
    if (lattices[1].num_found() < kMinStars) continue;
    for (const Seed& other : FindSimilarStars(seed)) {
      lattices.push_back(GrowFrom(image, other, kMinCorrelationRatio));
      lattices.push_back(GrowFrom(image, other, kMinReducedCorrelationRatio));
    }
    RemoveUsedCandidates(lattices[1], candidates);
    lattices.erase(std::remove_if(lattices.begin(), lattices.end(),
                                  [](const FeatureLattice& lattice) {
                                    return lattice.num_found() < kMinStars;
                                  }),
                   lattices.end());
    return lattices;
  }
  return {};
}

void RemoveUsedCandidates(const FeatureLattice& lattice,
                          std::vector<StarCandidate>* candidates) {
  constexpr double kNear = 0.75;  // fraction of the spacing
  for (const Feature& f : lattice.Features()) {
    double spacing_px = 0;
    for (const Correspondence& other :
         lattice.Around(f.column, f.row, 1, false))
      spacing_px = std::max(spacing_px, (other.pixel - f.pixel).norm());
    candidates->erase(
        std::remove_if(candidates->begin(), candidates->end(),
                       [&](const StarCandidate& candidate) {
                         return (candidate.pixel - f.pixel).norm() <
                                kNear * spacing_px;
                       }),
        candidates->end());
  }
}

}  // namespace raygrid
