#include "features/loose_lattice.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr double kMinCorrelation = 0.5;
constexpr int kMinStars = 12;   // of a lattice, or it is not believed
constexpr int kMaxTrials = 40;  // candidates
constexpr size_t kNumNearest = 12, kNumWitnesses = 40;

Board LooseBoard(int segments, int side) {
  Board board;
  board.kind = "star";
  board.columns = board.rows = side;
  board.square_m = 1;
  board.segments = segments;
  return board;
}

// The columns are the offsets to the stars to the right and below.
struct Basis {
  Eigen::Matrix2d linear;
  int support = 0;  // candidates where neighbours must be

  double Area() const { return linear.determinant(); }
};

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Offsets from a place to the candidates around it, nearest first.
std::vector<Eigen::Vector2d> OffsetsAround(
    const std::vector<StarCandidate>& candidates,
    const Eigen::Vector2d& center) {
  constexpr double kSamePx = 3;
  std::vector<Eigen::Vector2d> offsets;
  for (const StarCandidate& candidate : candidates)
    if ((candidate.pixel - center).norm() > kSamePx)
      offsets.push_back(candidate.pixel - center);
  const auto is_nearer = [](const Eigen::Vector2d& a,
                            const Eigen::Vector2d& b) {
    return a.squaredNorm() < b.squaredNorm();
  };
  const size_t count = std::min(kNumWitnesses, offsets.size());
  std::partial_sort(offsets.begin(), offsets.begin() + count, offsets.end(),
                    is_nearer);
  offsets.resize(count);
  return offsets;
}

int Support(const Eigen::Matrix2d& linear,
            const std::vector<Eigen::Vector2d>& offsets) {
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

// Pairs of neighbours that span a lattice that other candidates are on; the
// smallest first.
std::vector<Basis> BasesOf(const std::vector<Eigen::Vector2d>& offsets) {
  constexpr double kMinSine = 0.4, kMaxStretch = 5;
  constexpr int kMinSupport = 4;
  constexpr size_t kMaxBases = 10;
  const size_t count = std::min(kNumNearest, offsets.size());
  std::vector<Basis> bases;
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) {
      const Eigen::Vector2d &a = offsets[i], &b = offsets[j];
      // One of the four quarter turns of a basis is enough.
      if (a.x() < std::abs(a.y())) continue;
      const double product = a.norm() * b.norm();
      if (Cross(a, b) < kMinSine * product ||
          a.norm() > kMaxStretch * b.norm() ||
          b.norm() > kMaxStretch * a.norm())
        continue;
      Basis basis;
      basis.linear << a, b;
      basis.support = Support(basis.linear, offsets);
      if (basis.support >= kMinSupport) bases.push_back(basis);
    }
  }
  std::stable_sort(
      bases.begin(), bases.end(),
      [](const Basis& a, const Basis& b) { return a.support > b.support; });
  if (bases.size() > kMaxBases) bases.resize(kMaxBases);
  std::stable_sort(
      bases.begin(), bases.end(),
      [](const Basis& a, const Basis& b) { return a.Area() < b.Area(); });
  return bases;
}

Eigen::Matrix2d QuarterTurned(const Eigen::Matrix2d& linear) {
  Eigen::Matrix2d turned;
  turned << linear.col(1), -linear.col(0);
  return turned;
}

LocalMapping Shifted(LocalMapping mapping, const Eigen::Vector2d& offset) {
  mapping.center += mapping.linear * offset;
  return mapping;
}

}  // namespace

int QuarterTurnsThatKeepStars(int segments) {
  return segments % 8 == 0 ? 4 : segments % 4 == 0 ? 2 : 1;
}

LooseLatticeFinder::LooseLatticeFinder(int segments, int max_side,
                                       const DetectionOptions& options)
    : board_(LooseBoard(segments, 2 * max_side + 1)),
      texture_(segments),
      masks_(SymmetryMask::OfBoard(LooseBoard(segments, 1))),
      options_(options) {}

// Where a star and its four neighbours look like stars.
std::optional<LocalMapping> LooseLatticeFinder::MappingAround(
    const GreyImage& image, const std::vector<StarCandidate>& candidates,
    const Eigen::Vector2d& center) const {
  constexpr double kClearlyBetter = 0.1;
  constexpr double kMinTotal = 3 * kMinCorrelation;
  double best_total = kMinTotal - kClearlyBetter;
  std::optional<LocalMapping> best;
  const auto correlation = [&](const LocalMapping& mapping, double search_px) {
    const MatchingResult match = MatchStar(image, texture_, masks_[0], mapping,
                                           options_.window_px, search_px);
    return match.is_converged ? match.correlation : 0;
  };
  const int num_turns = 4 / QuarterTurnsThatKeepStars(board_.segments);
  for (const Basis& basis : BasesOf(OffsetsAround(candidates, center))) {
    LocalMapping mapping;
    mapping.center = center;
    mapping.linear = basis.linear;
    for (int turn = 0; turn < num_turns; ++turn) {
      double total = correlation(mapping, 1);
      if (total >= kMinCorrelation) {
        for (const Eigen::Vector2d& offset :
             {Eigen::Vector2d(1, 0), {-1, 0}, {0, 1}, {0, -1}})
          total += correlation(Shifted(mapping, offset), 2);
        if (total > best_total + kClearlyBetter) {
          best_total = total;
          best = mapping;
        }
      }
      mapping.linear = QuarterTurned(mapping.linear);
    }
  }
  return best;
}

std::optional<FeatureLattice> LooseLatticeFinder::Find(
    const GreyImage& image, std::vector<StarCandidate>* candidates) const {
  const int middle = board_.columns / 2;
  for (int trial = 0; trial < kMaxTrials && !candidates->empty(); ++trial) {
    const Eigen::Vector2d center = candidates->front().pixel;
    const auto mapping = MappingAround(image, *candidates, center);
    candidates->erase(candidates->begin());
    if (!mapping) continue;
    StarGrowth growth(image, board_, texture_, masks_, options_, {});
    for (int row = -1; row <= 1; ++row)
      for (int column = -1; column <= 1; ++column)
        growth.Try(middle + column, middle + row,
                   Shifted(*mapping, Eigen::Vector2d(column, row)), 0.2,
                   kMinCorrelation);
    growth.Grow(kMinCorrelation);
    if (growth.lattice().num_found() < kMinStars) continue;
    RemoveExplained(growth.lattice(), candidates);
    return growth.lattice();
  }
  return std::nullopt;
}

void RemoveExplained(const FeatureLattice& lattice,
                     std::vector<StarCandidate>* candidates) {
  constexpr double kNear = 0.75;  // of the distance to the next star
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
