#ifndef RAYGRID_FEATURES_REFINEMENT_SYMMETRY_MASK_H
#define RAYGRID_FEATURES_REFINEMENT_SYMMETRY_MASK_H

#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// The area around a feature in which the board is point-symmetric, as cells
/// with offsets of -kReach to kReach squares. Excludes tags, markers and the
/// board's edge, with a margin for blur.
class SymmetryMask {
 public:
  static constexpr double kReach = 1.5;
  static constexpr int kCells = 48;

  SymmetryMask() : cells_(kCells * kCells, 0) {}

  bool IsSymmetric(float u, float v) const {
    constexpr float kScale = static_cast<float>(kCells / (2 * kReach));
    const int i = static_cast<int>((u + static_cast<float>(kReach)) * kScale);
    const int j = static_cast<int>((v + static_cast<float>(kReach)) * kScale);
    return i >= 0 && j >= 0 && i < kCells && j < kCells &&
           cells_[j * kCells + i] != 0;
  }

  /// Returns one mask per feature of the board, indexed by PointIndex().
  static std::vector<SymmetryMask> MakeBoardMasks(const Board& board);

 private:
  std::vector<char> cells_;
};

/// Whether point reflection exchanges black and white: for stars of 6, 10, 14
/// ... segments.
inline bool ReflectionInvertsColors(const Board& board) {
  return board.segments % 4 == 2;
}

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_SYMMETRY_MASK_H
