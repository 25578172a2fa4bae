#include "features/squares/corner_growth.h"

#include <algorithm>
#include <array>

#include "appearance/board_appearance.h"

namespace raygrid {
namespace {

constexpr double kMinCornerSpacingPx = 5;
constexpr double kNear = 0.4;          // of the patches' reach
constexpr double kMinNearReachPx = 5;  // more than blur

// The reach of a patch: as far as corners of black squares can be told from
// each other. An AprilGrid is like a chessboard as far as the tags' borders and
// the black squares between them go: the tags' insides may be turned.
double PatchReach(const Board& board) {
  constexpr double kHalfSquare = 0.5, kTagBorder = 0.2;
  return board.kind == "aprilgrid" ? std::min(kTagBorder, board.spacing_ratio)
                                   : kHalfSquare;
}

// Whether another feature was found at a place.
bool IsTaken(const FeatureLattice& lattice, int column, int row,
             const Eigen::Vector2d& pixel, const LocalMapping& prediction) {
  for (const Correspondence& other : lattice.Around(column, row, 3, false)) {
    constexpr double kMinDistance = 0.6;  // of where the two should be
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
    // Corners of a chessboard look as those two rows before them do.
    const size_t index = patches_.size();
    const size_t two_rows = 2 * static_cast<size_t>(board.columns);
    if (board.kind == "chessboard" && index >= two_rows) {
      patches_.push_back(DrawnPatch(patches_[index - two_rows]));
      near_patches_.push_back(DrawnPatch(near_patches_[index - two_rows]));
      continue;
    }
    const auto is_black = [&](const Eigen::Vector2d& offset) {
      return appearance.IsBlack(point.head<2>() + board.square_m * offset);
    };
    patches_.emplace_back(PatchReach(board), is_black);
    near_patches_.emplace_back(kNear * PatchReach(board), is_black);
  }
}

bool CornerGrowth::Find(const GreyImage& image, int column, int row,
                        const LocalMapping& prediction, double search_squares,
                        const PatchCriterion& criterion,
                        FeatureLattice* lattice) const {
  const double spacing_px = prediction.SpacingPx();
  if (!(spacing_px >= kMinCornerSpacingPx)) return false;
  const int index = board_.PointIndex(column, row);
  PatchMatch match = FindPatch(image, patches_[index], prediction,
                               std::max(1.0, search_squares * spacing_px),
                               criterion.min_visible);
  if (match.correlation < criterion.min_correlation ||
      !WholeImage(image.size).Contains(match.pixel) ||
      IsTaken(*lattice, column, row, match.pixel, prediction))
    return false;
  const double near_px = kNear * PatchReach(board_) * spacing_px;
  if (near_px > kMinNearReachPx) {
    LocalMapping moved = prediction;
    moved.center = match.pixel;
    const PatchMatch nearer = FindPatch(image, near_patches_[index], moved,
                                        near_px / 2, criterion.min_visible);
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

// One pass over the places beside found ones, those with the most neighbours
// first, and not again before they have more; false if nothing was found.
bool CornerGrowth::Sweep(const GreyImage& image,
                         const PatchCriterion& criterion,
                         std::vector<int>* tried_with,
                         FeatureLattice* lattice) const {
  std::vector<std::array<int, 3>> candidates;
  for (int row = 0; row < board_.rows; ++row)
    for (int column = 0; column < board_.columns; ++column)
      if (!lattice->Has(column, row) &&
          HasDirectNeighbour(*lattice, column, row))
        candidates.push_back({-lattice->CountAround(column, row), row, column});
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

}  // namespace raygrid
