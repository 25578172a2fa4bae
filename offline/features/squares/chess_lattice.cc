#include "features/squares/chess_lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "features/squares/saddle_detection.h"

namespace raygrid {
namespace {

constexpr int kMaxSaddles = 3000;
constexpr int kMaxSeeds = 400;
// Stricter than the default: patches clipped by the image's edge may match the
// corner of a single square.
constexpr PatchCriterion kCriterion = {0.72, 0.9};
constexpr int kMinCorners = 6;

// Saddles are searched first at a scale with about this number of pixels, at
// which noise and blur matter less.
constexpr double kSearchPixels = 1e6;

std::vector<double> Scales(const ImageSize& size) {
  const double pixels = static_cast<double>(size.width) * size.height;
  double scale = 1;
  while (pixels * scale * scale > 2 * kSearchPixels) scale /= 2;
  std::vector<double> scales = {scale};
  for (double finer = 2 * scale; finer <= 1; finer *= 2)
    scales.push_back(finer);
  scales.push_back(scale / 2);
  if (scale == 1) scales.push_back(2);
  scales.push_back(scale / 4);
  return scales;
}

// Four corners of a square in an image: origin, along the two edges, opposite.
struct Seed {
  std::array<Eigen::Vector2d, 4> pixels;
  bool is_dark = false;
};

class SeedFinder {
 public:
  explicit SeedFinder(const std::vector<Saddle>& saddles) : saddles_(saddles) {}

  std::optional<Seed> FindSeed(const Saddle& origin) const {
    const auto [a, b] = origin.Edges();
    for (const auto& [right, down] :
         {std::pair{a, b}, {b, -a}, {-a, -b}, {-b, a}})
      if (const auto seed = FindSeedBetween(origin, right, down)) return seed;
    return std::nullopt;
  }

 private:
  using Direction = Eigen::Vector2d;

  std::optional<Seed> FindSeedBetween(const Saddle& origin,
                                      const Direction& right,
                                      const Direction& down) const {
    const bool is_dark = origin.IsDarkBetween(right, down);
    const auto along = [&](const Direction& direction) {
      return FindNearestSaddles(origin, [&](const Saddle& saddle) {
        constexpr double kMaxSine = 0.2;
        const Direction to = (saddle.pixel - origin.pixel).normalized();
        return to.dot(direction) > 0 &&
               std::fabs(to.x() * direction.y() - to.y() * direction.x()) <
                   kMaxSine &&
               saddle.IsDarkBetween(right, down) != is_dark;
      });
    };
    for (const Saddle* beside : along(right)) {
      for (const Saddle* below : along(down)) {
        const Eigen::Vector2d u = beside->pixel - origin.pixel;
        const Eigen::Vector2d v = below->pixel - origin.pixel;
        const double tolerance = 0.35 * std::min(u.norm(), v.norm());
        const auto opposite =
            FindNearestSaddles(origin, [&](const Saddle& saddle) {
              return (saddle.pixel - origin.pixel - u - v).norm() < tolerance &&
                     saddle.IsDarkBetween(right, down) == is_dark;
            });
        if (!opposite.empty())
          return Seed{
              {origin.pixel, beside->pixel, below->pixel, opposite[0]->pixel},
              is_dark};
      }
    }
    return std::nullopt;
  }

  // Returns up to three candidates of similar strength, nearest first.
  template <typename Condition>
  std::vector<const Saddle*> FindNearestSaddles(
      const Saddle& origin, const Condition& is_candidate) const {
    constexpr double kMaxRatio = 4;
    constexpr size_t kCount = 3;
    std::vector<const Saddle*> found;
    for (const Saddle& saddle : saddles_)
      if (&saddle != &origin && saddle.strength * kMaxRatio > origin.strength &&
          origin.strength * kMaxRatio > saddle.strength && is_candidate(saddle))
        found.push_back(&saddle);
    const auto distance = [&](const Saddle* saddle) {
      return (saddle->pixel - origin.pixel).squaredNorm();
    };
    std::stable_sort(found.begin(), found.end(),
                     [&](const Saddle* a, const Saddle* b) {
                       return distance(a) < distance(b);
                     });
    if (found.size() > kCount) found.resize(kCount);
    return found;
  }

  const std::vector<Saddle>& saddles_;
};

// A lattice grown from a seed.
struct GrownLattice {
  FeatureLattice lattice;
  std::vector<Feature> features;
};

bool IsOnLattice(const GrownLattice& grown, const Eigen::Vector2d& pixel) {
  constexpr double kNear = 0.3;  // fraction of the distance to a neighbour
  const FeatureLattice& lattice = grown.lattice;
  for (const Feature& f : grown.features)
    for (const auto& [dc, dr] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      if (lattice.Has(f.column + dc, f.row + dr) &&
          (pixel - f.pixel).norm() <
              kNear * (lattice.at(f.column + dc, f.row + dr) - f.pixel).norm())
        return true;
  return false;
}

Board Canvas(int max_side) {
  const int side = 2 * max_side + 3;
  return ChessboardPattern(side, side, 1).boards[0];
}

}  // namespace

ChessLatticeFinder::ChessLatticeFinder(int max_side)
    : canvas_(Canvas(max_side)), growth_(canvas_) {}

void ChessLatticeFinder::Find(
    const GreyImage& image,
    const std::function<bool(const FeatureLattice&)>& is_wanted) const {
  std::vector<GrownLattice> all;
  const auto grow = [&](const Seed& seed) {
    FeatureLattice lattice(canvas_);
    const int row = canvas_.rows / 2;
    const int column =
        canvas_.columns / 2 +
        ((canvas_.columns / 2 + row) % 2 == (seed.is_dark ? 0 : 1) ? 0 : 1);
    const auto& p = seed.pixels;
    for (int k = 0; k < 4; ++k) {
      LocalMapping mapping;
      mapping.center = p[k];
      mapping.linear.col(0) = k < 2 ? p[1] - p[0] : p[3] - p[2];
      mapping.linear.col(1) = k % 2 == 0 ? p[2] - p[0] : p[3] - p[1];
      constexpr double kSearchSquares = 0.1;
      if (!growth_.Find(image, column + k % 2, row + k / 2, mapping,
                        kSearchSquares, kCriterion, &lattice))
        return lattice;
    }
    growth_.Grow(image, kCriterion, &lattice);
    return lattice;
  };
  for (const double scale : Scales(image.size)) {
    const std::vector<Saddle> saddles = FindSaddles(image, scale, kMaxSaddles);
    const SeedFinder finder(saddles);
    int num_seeds = 0;
    for (const Saddle& saddle : saddles) {
      if (num_seeds > kMaxSeeds) break;
      ++num_seeds;
      if (std::any_of(all.begin(), all.end(), [&](const GrownLattice& grown) {
            return IsOnLattice(grown, saddle.pixel);
          }))
        continue;
      const auto seed = finder.FindSeed(saddle);
      if (!seed) continue;
      FeatureLattice lattice = grow(*seed);
      if (lattice.num_found() < kMinCorners) continue;
      if (is_wanted(lattice)) return;
      std::vector<Feature> features = lattice.Features();
      all.push_back({std::move(lattice), std::move(features)});
    }
  }
  for (GrownLattice& grown : all)
    if (growth_.GrowWithSpacingRatio(image, kCriterion, &grown.lattice) &&
        is_wanted(grown.lattice))
      return;
}

}  // namespace raygrid
