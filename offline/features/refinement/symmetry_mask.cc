#include "features/refinement/symmetry_mask.h"

#include <algorithm>
#include <cmath>

#include "appearance/board_appearance.h"

namespace raygrid {
namespace {

constexpr double kCellSquares = 2 * SymmetryMask::kReach / SymmetryMask::kCells;

// Returns the distance from asymmetric cells that is excluded because of blur,
// in squares. Limited to about half of the gap between a corner's edges and the
// cells of markers; otherwise the edges would be excluded, too.
double MarginSquares(const Board& board) {
  constexpr double kMargin = 0.15;
  const double between = KindOf(board).MarkerDistance(board);
  return std::min(kMargin, std::max(0.57 * between, 1.1 * kCellSquares));
}

// Returns the board offset of a cell; not its exact centre, so that no sample
// lies on the edge of a segment.
Eigen::Vector2d CellOffset(int i, int j) {
  return {(i + 0.51) * kCellSquares - SymmetryMask::kReach,
          (j + 0.507) * kCellSquares - SymmetryMask::kReach};
}

std::vector<char> AsymmetricCells(const BoardAppearance& appearance,
                                  const Board& board,
                                  const Eigen::Vector2d& center) {
  constexpr int n = SymmetryMask::kCells;
  const bool inverts = ReflectionInvertsColors(board);
  std::vector<char> is_asymmetric(n * n);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector2d offset = CellOffset(i, j) * board.square_m;
      is_asymmetric[j * n + i] =
          (appearance.IsBlack(center + offset) ==
           appearance.IsBlack(center - offset)) == inverts;
    }
  }
  return is_asymmetric;
}

// Whether a marked cell is closer than the margin.
bool IsNear(const std::vector<char>& cells, double margin, int i, int j) {
  constexpr int n = SymmetryMask::kCells;
  const int reach = static_cast<int>(margin / kCellSquares);
  for (int y = std::max(j - reach, 0); y <= std::min(j + reach, n - 1); ++y)
    for (int x = std::max(i - reach, 0); x <= std::min(i + reach, n - 1); ++x)
      if (cells[y * n + x] && std::hypot(x - i, y - j) * kCellSquares < margin)
        return true;
  return false;
}

}  // namespace

std::vector<SymmetryMask> SymmetryMask::MakeBoardMasks(const Board& board) {
  const BoardAppearance appearance(board);
  const double margin = MarginSquares(board);
  std::vector<SymmetryMask> masks(board.num_points());
  const std::vector<Eigen::Vector3d> points = board.NominalPoints();
  for (int feature = 0; feature < board.num_points(); ++feature) {
    const std::vector<char> cells =
        AsymmetricCells(appearance, board, points[feature].head<2>());
    if (std::count(cells.begin(), cells.end(), 1) == 0) {
      masks[feature].cells_.assign(cells.size(), 1);
      continue;
    }
    for (int j = 0; j < kCells; ++j)
      for (int i = 0; i < kCells; ++i)
        masks[feature].cells_[j * kCells + i] =
            !IsNear(cells, margin, i, j) &&
            !IsNear(cells, margin, kCells - 1 - i, kCells - 1 - j);
  }
  return masks;
}

}  // namespace raygrid
