/// The ink coverage of a small patch of a board, exact where at most one edge
/// crosses it. Rendering evaluates it hundreds of times per pixel.
#ifndef RAYGRID_SIMULATION_INK_MAP_H
#define RAYGRID_SIMULATION_INK_MAP_H

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "appearance/board_appearance.h"

namespace raygrid {

/// A parallelogram in the board's plane, about any centre.
class Footprint {
 public:
  /// sides_m: edge vectors as columns, in metres
  explicit Footprint(const Eigen::Matrix2d& sides_m) : sides_m_(sides_m) {}

  const Eigen::Matrix2d& sides_m() const { return sides_m_; }
  double radius_m() const {
    return (sides_m_.col(0).norm() + sides_m_.col(1).norm()) / 2;
  }
  /// Returns the fraction, 0 to 1, of the patch where normal . point > 0, if
  /// normal . center = distance.
  double ComputeFractionBeyondLine(const Eigen::Vector2d& normal,
                                   double distance_m) const;

 private:
  Eigen::Matrix2d sides_m_;
};

/// A grid over the board. A cell stores its colour, or the only edge of ink
/// near it, or that there are several; then the patch is subdivided.
class InkMap {
 public:
  explicit InkMap(const BoardAppearance& appearance);

  /// Returns the ink coverage, 0 to 1, of the patch about center_m.
  double InkFraction(const Eigen::Vector2d& center_m,
                     const Footprint& footprint) const;

 private:
  // A boundary of ink: normal . point > offset is black for edges in the first
  // half of edges_, white in the second half.
  struct Edge {
    Eigen::Vector2d normal;
    double offset;
  };
  enum : int32_t { kWhite = -1, kBlack = -2, kMultipleEdges = -3, kEmpty = -4 };

  void AddEdge(const Eigen::Vector2d& a, const Eigen::Vector2d& b);
  void MarkCell(int column, int row, int32_t edge);
  void ColorCells();
  int32_t ColorCell(const Eigen::Vector2d& point_m) const;
  Eigen::Vector2d CellCenter(int column, int row) const;
  int32_t CellAt(const Eigen::Vector2d& point_m) const;
  double ComputePatchInk(const Eigen::Vector2d& center_m, const Footprint& part,
                         int32_t cell) const;
  double ComputeSubdividedInk(const Eigen::Vector2d& center_m,
                              const Footprint& footprint,
                              int patches_along_side) const;

  BoardAppearance appearance_;
  Eigen::Vector2d corner_m_;  // corner of the first cell
  double cell_m_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<Edge> edges_;
  std::vector<int32_t> cells_;  // index into edges_, or an enumerator
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_INK_MAP_H
