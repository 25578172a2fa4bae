#include "features/squares/corner_growth.h"

#include <algorithm>
#include <array>
#include <complex>
#include <cstdlib>
#include <optional>
#include <utility>

#include "appearance/board_appearance.h"

namespace raygrid {
namespace {

constexpr double kMinCornerSpacingPx = 5;
constexpr double kNearFraction = 0.4;   // fraction of the patch radius
constexpr double kMinNearRadiusPx = 5;  // larger than blur

// Returns the radius of a patch, in squares, within which corners are
// unambiguous. An AprilGrid resembles a chessboard only up to the tags' borders
// and the squares between them, since the tags may be rotated.
double ComputePatchRadius(const Board& board) {
  constexpr double kHalfSquare = 0.5;
  return board.IsTagGrid() ? KindOf(board).MarkerDistance(board) : kHalfSquare;
}

// Whether another feature was detected near the pixel.
bool IsOccupied(const FeatureLattice& lattice, int column, int row,
                const Eigen::Vector2d& pixel, const LocalMapping& prediction) {
  for (const Correspondence& other : lattice.Around(column, row, 3, false)) {
    constexpr double kMinDistance = 0.6;  // fraction of the expected distance
    if ((other.pixel - pixel).norm() <
        kMinDistance * (prediction.linear * other.offset).norm())
      return true;
  }
  return false;
}

bool HasDirectNeighbour(const FeatureLattice& lattice, int column, int row) {
  return lattice.Has(column - 1, row) || lattice.Has(column + 1, row) ||
         lattice.Has(column, row - 1) || lattice.Has(column, row + 1);
}

using Step = std::complex<double>;  // between two features, pixels

Step ComputeStepToNeighbor(const FeatureLattice& lattice, int column, int row,
                           int x, int y) {
  const Eigen::Vector2d step =
      lattice.at(column, row) - lattice.at(column - x, row - y);
  return {step.x(), step.y()};
}

// Returns the step across a line at a feature: to the next feature or from the
// previous one.
std::optional<Step> ComputeStepAcross(const FeatureLattice& lattice, int column,
                                      int row, int x, int y) {
  if (lattice.Has(column + x, row + y))
    return ComputeStepToNeighbor(lattice, column + x, row + y, x, y);
  if (lattice.Has(column - x, row - y))
    return ComputeStepToNeighbor(lattice, column, row, x, y);
  return std::nullopt;
}

// Predicts a feature from the three previous ones along (x, y), assuming that
// the ratio of successive steps (as complex numbers) is constant.
bool PredictWithSpacingRatio(const FeatureLattice& lattice, int column, int row,
                             int x, int y, LocalMapping* prediction) {
  for (int k = 1; k <= 3; ++k)
    if (!lattice.Has(column - k * x, row - k * y)) return false;
  const auto across =
      ComputeStepAcross(lattice, column - x, row - y, std::abs(y), std::abs(x));
  if (!across) return false;
  const Step last = ComputeStepToNeighbor(lattice, column - x, row - y, x, y);
  const Step ratio =
      last / ComputeStepToNeighbor(lattice, column - 2 * x, row - 2 * y, x, y);
  const Step next = last * ratio;
  const Step here = next * (1.0 + ratio) / 2.0 * static_cast<double>(x + y);
  const Eigen::Vector2d along(here.real(), here.imag());
  const Eigen::Vector2d beside(across->real(), across->imag());
  *prediction = LocalMapping();
  prediction->center = lattice.at(column - x, row - y) +
                       Eigen::Vector2d(next.real(), next.imag());
  prediction->linear.col(0) = x != 0 ? along : beside;
  prediction->linear.col(1) = x != 0 ? beside : along;
  return true;
}

}  // namespace

bool PredictFeature(const FeatureLattice& lattice, int column, int row,
                    LocalMapping* prediction) {
  std::vector<Correspondence> around = lattice.Around(column, row, 2, false);
  if (around.size() < 6) around = lattice.Around(column, row, 3, false);
  return FitLocalMapping(around, 2, prediction) > 0;
}

CornerGrowth::CornerGrowth(const Board& board) : board_(board) {
  const BoardAppearance appearance(board);
  for (const Eigen::Vector3d& point : board.NominalPoints()) {
    // Without markers, the pattern repeats every two rows.
    const size_t index = patches_.size();
    const size_t two_rows = 2 * static_cast<size_t>(board.columns);
    if (!board.HasMarkers() && index >= two_rows) {
      patches_.push_back(DrawnPatch(patches_[index - two_rows]));
      near_patches_.push_back(DrawnPatch(near_patches_[index - two_rows]));
      continue;
    }
    const auto is_black = [&](const Eigen::Vector2d& offset) {
      return appearance.IsBlack(point.head<2>() + board.square_m * offset);
    };
    patches_.emplace_back(ComputePatchRadius(board), is_black);
    near_patches_.emplace_back(kNearFraction * ComputePatchRadius(board),
                               is_black);
  }
}

bool CornerGrowth::Find(const GreyImage& image, int column, int row,
                        const LocalMapping& prediction, double search_squares,
                        const PatchCriterion& criterion,
                        FeatureLattice* lattice) const {
  const double spacing_px = prediction.SpacingPx();
  if (!(spacing_px >= kMinCornerSpacingPx)) return false;
  const int index = board_.PointIndex(column, row);
  PatchCorrelation match = FindPatch(image, patches_[index], prediction,
                                     std::max(1.0, search_squares * spacing_px),
                                     criterion.min_visible);
  if (match.correlation < criterion.min_correlation ||
      !WholeImage(image.size).Contains(match.pixel) ||
      IsOccupied(*lattice, column, row, match.pixel, prediction))
    return false;
  const double near_px =
      kNearFraction * ComputePatchRadius(board_) * spacing_px;
  if (near_px > kMinNearRadiusPx) {
    LocalMapping moved = prediction;
    moved.center = match.pixel;
    const PatchCorrelation nearer = FindPatch(
        image, near_patches_[index], moved, near_px / 2, criterion.min_visible);
    if (nearer.correlation > criterion.min_correlation) match = nearer;
  }
  lattice->Set(column, row, match.pixel);
  return true;
}

void CornerGrowth::Grow(const GreyImage& image, const PatchCriterion& criterion,
                        FeatureLattice* lattice) const {
  std::vector<int> tried_with(board_.num_points(), 0);
  while (Sweep(image, criterion, &tried_with, lattice)) {
  }
}

// One pass over the undetected features next to detected ones, in descending
// order of the number of neighbours; retries a feature only with more
// neighbours than before. Returns false if none was found.
bool CornerGrowth::Sweep(const GreyImage& image,
                         const PatchCriterion& criterion,
                         std::vector<int>* tried_with,
                         FeatureLattice* lattice) const {
  std::vector<std::array<int, 3>> candidates;
  for (int row = 0; row < board_.rows; ++row)
    for (int column = 0; column < board_.columns; ++column)
      if (!lattice->Has(column, row) &&
          HasDirectNeighbour(*lattice, column, row))
        candidates.push_back(
            {-lattice->CountNeighbours(column, row), row, column});
  std::sort(candidates.begin(), candidates.end());
  bool is_any_found = false;
  for (const auto& [minus_count, row, column] : candidates) {
    int& tried = (*tried_with)[board_.PointIndex(column, row)];
    if (-minus_count <= tried) continue;
    tried = -minus_count;
    constexpr int kManyNeighbours = 8;
    const double search_squares = tried >= kManyNeighbours ? 0.12 : 0.25;
    LocalMapping prediction;
    if (PredictFeature(*lattice, column, row, &prediction))
      is_any_found |= Find(image, column, row, prediction, search_squares,
                           criterion, lattice);
  }
  return is_any_found;
}

bool CornerGrowth::GrowWithSpacingRatio(const GreyImage& image,
                                        const PatchCriterion& criterion,
                                        FeatureLattice* lattice) const {
  const int num_before = lattice->num_found();
  int num_known;
  do {
    num_known = lattice->num_found();
    for (int row = 0; row < board_.rows; ++row)
      for (int column = 0; column < board_.columns; ++column)
        FindWithSpacingRatio(image, column, row, criterion, lattice);
    if (lattice->num_found() > num_known) Grow(image, criterion, lattice);
  } while (lattice->num_found() > num_known);
  return lattice->num_found() > num_before;
}

void CornerGrowth::FindWithSpacingRatio(const GreyImage& image, int column,
                                        int row,
                                        const PatchCriterion& criterion,
                                        FeatureLattice* lattice) const {
  constexpr double kSearchSquares = 0.25;
  for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    LocalMapping prediction;
    if (!lattice->Has(column, row) &&
        PredictWithSpacingRatio(*lattice, column, row, x, y, &prediction))
      Find(image, column, row, prediction, kSearchSquares, criterion, lattice);
  }
}

}  // namespace raygrid
