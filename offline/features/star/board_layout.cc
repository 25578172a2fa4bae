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
constexpr double kMaxWrong = 0.1, kMaxWrongNearStars = 0.15;
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

enum class Shade : char { kUnsure, kWhite, kBlack };

template <typename IsBlack>
Shade ComputeShade(const Eigen::Vector2d& center, const IsBlack& is_black_at) {
  constexpr double kMargin = 0.045;  // squares
  const bool is_black = is_black_at(center);
  for (const double v : {-kMargin, kMargin})
    for (const double u : {-kMargin, kMargin})
      if (is_black_at(center + Eigen::Vector2d(u, v)) != is_black)
        return Shade::kUnsure;
  return is_black ? Shade::kBlack : Shade::kWhite;
}

// The expected appearance of a board at all sample points; kUnsure near edges
// between black and white.
class ExpectedSubcells {
 public:
  explicit ExpectedSubcells(const Board& board)
      : columns_(board.columns + 2), rows_(board.rows + 2) {
    const BoardAppearance appearance(board);
    shades_.reserve(static_cast<size_t>(columns_) * rows_ * kSubcellsPerSquare);
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column)
        for (int part = 0; part < kSubcellsPerSquare; ++part)
          shades_.push_back(ComputeShade(
              Eigen::Vector2d(column - 1, row - 1) + GetSubcellOffset(part),
              [&](const Eigen::Vector2d& p) {
                return appearance.IsBlack(board.square_m * p);
              }));
  }

  // The appearance is defined up to one square outside the outermost features.
  bool Knows(const Eigen::Vector2i& place) const {
    return place.x() >= -1 && place.y() >= -1 && place.x() < columns_ - 1 &&
           place.y() < rows_ - 1;
  }
  Shade At(const Eigen::Vector2i& place, const Eigen::Vector2d& offset) const {
    const Eigen::Array2i part = ((offset.array() + 0.5) * kSubcellsPerSide)
                                    .floor()
                                    .cast<int>()
                                    .max(0)
                                    .min(kSubcellsPerSide - 1);
    const size_t square =
        static_cast<size_t>(place.y() + 1) * columns_ + place.x() + 1;
    return shades_[square * kSubcellsPerSquare + part.y() * kSubcellsPerSide +
                   part.x()];
  }

 private:
  int columns_, rows_;
  std::vector<Shade> shades_;
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
      const Shade shade = ComputeShade(offset, [&](const Eigen::Vector2d& p) {
        return IsBlackInStar(segments_, p.x(), p.y());
      });
      if (shade == Shade::kUnsure) continue;
      const bool is_black = shade == Shade::kBlack;
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
struct Verdicts {
  std::vector<signed char> subcell_values;
  int num_right = 0, num_wrong = 0;
  int num_right_nearby = 0, num_wrong_nearby = 0;  // at positions without a
                                                   // star

  bool IsPlausible() const {
    return num_wrong <= kMaxWrong * (num_right + num_wrong) &&
           num_wrong_nearby <=
               kMaxWrongNearStars * (num_right_nearby + num_wrong_nearby);
  }
};

Verdicts CollectAssessments(const LatticePlacement& placement,
                            const ExpectedSubcells& expected,
                            const std::vector<SampledSubcell>& seen) {
  Verdicts verdicts;
  verdicts.subcell_values.reserve(seen.size());
  for (const SampledSubcell& part : seen) {
    const Eigen::Vector2i place =
        placement.OnBoard(part.place.x(), part.place.y());
    signed char assessment = 0;
    if (expected.Knows(place)) {
      const Eigen::Vector2d on_board = placement.OnBoard(
          Eigen::Vector2d(part.place.cast<double>() + part.offset));
      const Shade shade = expected.At(place, on_board - place.cast<double>());
      if (shade != Shade::kUnsure)
        assessment = (shade == Shade::kBlack) == part.is_black ? 1 : -1;
    } else if (part.is_on_star) {
      assessment = -1;
    }
    verdicts.subcell_values.push_back(assessment);
    verdicts.num_right += assessment > 0;
    verdicts.num_wrong += assessment < 0;
    verdicts.num_right_nearby += assessment > 0 && !part.is_on_star;
    verdicts.num_wrong_nearby += assessment < 0 && !part.is_on_star;
  }
  return verdicts;
}

bool Refutes(const Verdicts& a, const Verdicts& b,
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
  std::vector<Verdicts> verdicts;
  verdicts.reserve(placements.size());
  for (const LatticePlacement& placement : placements)
    verdicts.push_back(CollectAssessments(placement, expected, seen));
  const auto best = std::min_element(verdicts.begin(), verdicts.end(),
                                     [](const Verdicts& a, const Verdicts& b) {
                                       return a.num_wrong - a.num_right <
                                              b.num_wrong - b.num_right;
                                     });
  if (!best->IsPlausible()) return std::nullopt;
  for (const Verdicts& rival : verdicts)
    if (&rival != &*best && !Refutes(*best, rival, seen)) return std::nullopt;
  return placements[best - verdicts.begin()];
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
