#include "features/star/board_layout.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "appearance/board_appearance.h"
#include "dataset/kinds/star.h"

namespace raygrid {
namespace {

// The square around each lattice position is sampled at 8 x 8 points.
constexpr int kSubcellsPerSide = 8;
constexpr int kSubcellsPerSquare = kSubcellsPerSide * kSubcellsPerSide;
constexpr int kLayoutRadius = 4;  // in squares: stars used for local mappings
constexpr int kMaxStarDistance = 2;       // in squares from the nearest star
constexpr double kMinLayoutContrast = 8;  // grey levels
// Maximum fractions of mismatches among all samples, and among samples at
// positions without a detected star.
constexpr double kMaxMismatchFraction = 0.1,
                 kMaxMismatchFractionNearStars = 0.15;
// Minimum number of samples, and of squares containing them, at which the best
// placement matches and a rival does not.
constexpr int kMinMoreRight = 12, kMinSquaresRight = 2;
constexpr double kMaxWrongWhereRivalIsRight = 0.15;

// Returns the offset of a sample from the centre of its square.
Eigen::Vector2d GetSubcellOffset(int part) {
  return Eigen::Vector2d(part % kSubcellsPerSide + 0.5,
                         part / kSubcellsPerSide + 0.5) /
             kSubcellsPerSide -
         Eigen::Vector2d(0.5, 0.5);
}

enum class SquareColor : char { kUncertain, kWhite, kBlack };

template <typename IsBlack>
SquareColor ClassifyColor(const Eigen::Vector2d& center,
                          const IsBlack& is_black_at) {
  constexpr double kMargin = 0.045;  // squares
  const bool is_black = is_black_at(center);
  for (const double v : {-kMargin, kMargin})
    for (const double u : {-kMargin, kMargin})
      if (is_black_at(center + Eigen::Vector2d(u, v)) != is_black)
        return SquareColor::kUncertain;
  return is_black ? SquareColor::kBlack : SquareColor::kWhite;
}

// The expected appearance of a board at all sample points; kUncertain near
// edges between black and white.
class ExpectedSubcells {
 public:
  explicit ExpectedSubcells(const Board& board)
      : columns_(board.columns + 2), rows_(board.rows + 2) {
    const BoardAppearance appearance(board);
    colors_.reserve(static_cast<size_t>(columns_) * rows_ * kSubcellsPerSquare);
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column)
        for (int part = 0; part < kSubcellsPerSquare; ++part)
          colors_.push_back(ClassifyColor(
              Eigen::Vector2d(column - 1, row - 1) + GetSubcellOffset(part),
              [&](const Eigen::Vector2d& p) {
                return appearance.IsBlack(board.square_m * p);
              }));
  }

  // The appearance is defined up to one square outside the outermost features.
  bool HasSegments(const Eigen::Vector2i& place) const {
    return place.x() >= -1 && place.y() >= -1 && place.x() < columns_ - 1 &&
           place.y() < rows_ - 1;
  }
  SquareColor At(const Eigen::Vector2i& place,
                 const Eigen::Vector2d& offset) const {
    const Eigen::Array2i part = ((offset.array() + 0.5) * kSubcellsPerSide)
                                    .floor()
                                    .cast<int>()
                                    .max(0)
                                    .min(kSubcellsPerSide - 1);
    const size_t square =
        static_cast<size_t>(place.y() + 1) * columns_ + place.x() + 1;
    return colors_[square * kSubcellsPerSquare + part.y() * kSubcellsPerSide +
                   part.x()];
  }

 private:
  int columns_, rows_;
  std::vector<SquareColor> colors_;
};

// A sample that is clearly black or white.
struct SampledSubcell {
  Eigen::Vector2i place;  // lattice position
  Eigen::Vector2d offset;
  bool is_black, is_on_star;
};

struct Levels {
  double white = 0, black = 0;
};

class SubcellReader {
 public:
  SubcellReader(const GreyImage& image, const FeatureLattice& lattice,
                int segments)
      : image_(image),
        lattice_(lattice),
        segments_(segments),
        stars_(lattice.Features()) {}

  std::vector<SampledSubcell> ReadAll() {
    std::vector<SampledSubcell> seen;
    for (const Eigen::Vector2i& place : ListPositionsNearStars())
      ReadSquare(place, &seen);
    return seen;
  }

 private:
  std::vector<Eigen::Vector2i> ListPositionsNearStars() const {
    std::vector<Eigen::Vector2i> places;
    for (const Feature& star : stars_)
      for (int v = -kMaxStarDistance; v <= kMaxStarDistance; ++v)
        for (int u = -kMaxStarDistance; u <= kMaxStarDistance; ++u)
          if (lattice_.IsOnBoard(star.column + u, star.row + v))
            places.emplace_back(star.column + u, star.row + v);
    const auto is_before = [](const Eigen::Vector2i& a,
                              const Eigen::Vector2i& b) {
      return std::pair(a.y(), a.x()) < std::pair(b.y(), b.x());
    };
    std::sort(places.begin(), places.end(), is_before);
    places.erase(std::unique(places.begin(), places.end()), places.end());
    return places;
  }

  std::optional<double> SampleGreyLevel(const LocalMapping& mapping,
                                        const Eigen::Vector2d& offset) const {
    const Eigen::Vector2d pixel = mapping(offset);
    if (!WholeImage(image_.size).Contains(pixel)) return std::nullopt;
    return image_.at(static_cast<int>(std::lround(pixel.x())),
                     static_cast<int>(std::lround(pixel.y())));
  }

  // Estimates the black and white levels from the segments of the nearest star.
  std::optional<Levels> GetNearestGreyLevels(
      const Eigen::Vector2i& place) const {
    const Feature& star = *std::min_element(
        stars_.begin(), stars_.end(), [&](const Feature& a, const Feature& b) {
          return (Eigen::Vector2i(a.column, a.row) - place).squaredNorm() <
                 (Eigen::Vector2i(b.column, b.row) - place).squaredNorm();
        });
    LocalMapping mapping;
    if (!FitLocalMapping(
            lattice_.Around(star.column, star.row, kLayoutRadius, true), 2,
            &mapping))
      return std::nullopt;
    double sums[2] = {0, 0};
    int counts[2] = {0, 0};
    for (int part = 0; part < kSubcellsPerSquare; ++part) {
      const Eigen::Vector2d offset = GetSubcellOffset(part);
      const auto level = SampleGreyLevel(mapping, offset);
      if (!level) continue;
      const SquareColor shade =
          ClassifyColor(offset, [&](const Eigen::Vector2d& p) {
            return IsBlackInStar(segments_, p.x(), p.y());
          });
      if (shade == SquareColor::kUncertain) continue;
      const bool is_black = shade == SquareColor::kBlack;
      sums[is_black] += *level;
      ++counts[is_black];
    }
    if (std::min(counts[0], counts[1]) < 4) return std::nullopt;
    const Levels levels = {sums[0] / counts[0], sums[1] / counts[1]};
    if (levels.white - levels.black < kMinLayoutContrast) return std::nullopt;
    return levels;
  }

  void ReadSquare(const Eigen::Vector2i& place,
                  std::vector<SampledSubcell>* seen) const {
    LocalMapping mapping;
    if (!FitLocalMapping(
            lattice_.Around(place.x(), place.y(), kLayoutRadius, true), 2,
            &mapping))
      return;
    if (!WholeImage(image_.size).Contains(mapping.center, 20)) return;
    const auto levels = GetNearestGreyLevels(place);
    if (!levels) return;
    for (int part = 0; part < kSubcellsPerSquare; ++part) {
      const Eigen::Vector2d offset = GetSubcellOffset(part);
      const auto level = SampleGreyLevel(mapping, offset);
      if (!level) continue;
      constexpr double kMinContrastFraction = 0.35;
      const double whiteness =
          (*level - levels->black) / (levels->white - levels->black);
      if (std::abs(whiteness - 0.5) < 0.5 - kMinContrastFraction) continue;
      seen->push_back(
          {place, offset, whiteness < 0.5, lattice_.Has(place.x(), place.y())});
    }
  }

  const GreyImage& image_;
  const FeatureLattice& lattice_;
  int segments_;
  std::vector<Feature> stars_;
};

// The result of comparing each sample with a placement: 1 match, -1 mismatch, 0
// undefined.
struct LayoutComparison {
  std::vector<signed char> subcell_values;
  int num_matches = 0, num_mismatches = 0;
  int num_nearby_matches = 0, num_nearby_mismatches = 0;  // at positions
                                                          // without a star

  bool IsPlausible() const {
    return num_mismatches <=
               kMaxMismatchFraction * (num_matches + num_mismatches) &&
           num_nearby_mismatches <=
               kMaxMismatchFractionNearStars *
                   (num_nearby_matches + num_nearby_mismatches);
  }
};

LayoutComparison CollectAssessments(const LatticePlacement& placement,
                                    const ExpectedSubcells& expected,
                                    const std::vector<SampledSubcell>& seen) {
  LayoutComparison comparison;
  comparison.subcell_values.reserve(seen.size());
  for (const SampledSubcell& part : seen) {
    const Eigen::Vector2i place =
        placement.OnBoard(part.place.x(), part.place.y());
    signed char assessment = 0;
    if (expected.HasSegments(place)) {
      const Eigen::Vector2d on_board = placement.OnBoard(
          Eigen::Vector2d(part.place.cast<double>() + part.offset));
      const SquareColor shade =
          expected.At(place, on_board - place.cast<double>());
      if (shade != SquareColor::kUncertain)
        assessment = (shade == SquareColor::kBlack) == part.is_black ? 1 : -1;
    } else if (part.is_on_star) {
      assessment = -1;
    }
    comparison.subcell_values.push_back(assessment);
    comparison.num_matches += assessment > 0;
    comparison.num_mismatches += assessment < 0;
    comparison.num_nearby_matches += assessment > 0 && !part.is_on_star;
    comparison.num_nearby_mismatches += assessment < 0 && !part.is_on_star;
  }
  return comparison;
}

bool Contradicts(const LayoutComparison& a, const LayoutComparison& b,
                 const std::vector<SampledSubcell>& seen) {
  int num_a = 0, num_b = 0, num_squares = 0;
  const Eigen::Vector2i* last_square = nullptr;
  for (size_t i = 0; i < seen.size(); ++i) {
    num_b += a.subcell_values[i] < 0 && b.subcell_values[i] > 0;
    if (a.subcell_values[i] <= 0 || b.subcell_values[i] >= 0) continue;
    ++num_a;
    num_squares += !last_square || *last_square != seen[i].place;
    last_square = &seen[i].place;
  }
  return num_a - num_b >= kMinMoreRight && num_squares >= kMinSquaresRight &&
         num_b <= kMaxWrongWhereRivalIsRight * (num_a + num_b);
}

}  // namespace

std::optional<LatticePlacement> AssignWithLayout(const GreyImage& image,
                                                 const FeatureLattice& lattice,
                                                 const Board& board) {
  const auto placements = ListPlacements(lattice.Features(), board);
  if (placements.empty()) return std::nullopt;
  const std::vector<SampledSubcell> seen =
      SubcellReader(image, lattice, board.segments).ReadAll();
  const ExpectedSubcells expected(board);
  std::vector<LayoutComparison> comparison;
  comparison.reserve(placements.size());
  for (const LatticePlacement& placement : placements)
    comparison.push_back(CollectAssessments(placement, expected, seen));
  const auto best = std::min_element(
      comparison.begin(), comparison.end(),
      [](const LayoutComparison& a, const LayoutComparison& b) {
        return a.num_mismatches - a.num_matches <
               b.num_mismatches - b.num_matches;
      });
  if (!best->IsPlausible()) return std::nullopt;
  for (const LayoutComparison& rival : comparison)
    if (&rival != &*best && !Contradicts(*best, rival, seen))
      return std::nullopt;
  return placements[best - comparison.begin()];
}

bool AreOnBoard(const std::vector<Feature>& others,
                const FeatureLattice& lattice,
                const LatticePlacement& placement, const Board& board) {
  constexpr double kMaxSquaresAway = 6;  // maximum extrapolation of the local
                                         // mapping
  constexpr int kMaxOnBoard = 2;
  const std::vector<Feature> stars = lattice.Features();
  int num_on_board = 0;
  for (const Feature& other : others) {
    const Feature& star = *std::min_element(
        stars.begin(), stars.end(), [&](const Feature& a, const Feature& b) {
          return (a.pixel - other.pixel).squaredNorm() <
                 (b.pixel - other.pixel).squaredNorm();
        });
    LocalMapping mapping;
    if (!FitLocalMapping(lattice.Around(star.column, star.row, 2, true), 1,
                         &mapping))
      continue;
    const Eigen::Vector2d offset =
        mapping.linear.inverse() * (other.pixel - star.pixel);
    if (!(offset.cwiseAbs().maxCoeff() <= kMaxSquaresAway)) continue;
    const Eigen::Vector2d p = placement.OnBoard(
        Eigen::Vector2d(Eigen::Vector2d(star.column, star.row) + offset));
    num_on_board += p.x() > -0.5 && p.y() > -0.5 &&
                    p.x() < board.columns - 0.5 && p.y() < board.rows - 0.5;
  }
  return num_on_board > kMaxOnBoard;
}

}  // namespace raygrid
