#ifndef RAYGRID_FEATURES_STAR_LATTICE_PLACEMENT_H
#define RAYGRID_FEATURES_STAR_LATTICE_PLACEMENT_H

#include <Eigen/Core>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

/// The placement of a lattice of stars on a board: rotation by multiples of 90
/// degrees, then translation.
struct LatticePlacement {
  int board = 0;  ///< index among the requested boards
  int quarter_turns = 0;
  int column = 0, row = 0;  ///< board position of lattice (0, 0)

  Eigen::Vector2i OnBoard(int lattice_column, int lattice_row) const;
  Eigen::Vector2d OnBoard(const Eigen::Vector2d& on_lattice) const;
  Eigen::Vector2d OnLattice(const Eigen::Vector2d& on_board) const;
};

/// Returns all placements in which stars of the lattice coincide with stars of
/// the board, except a few: half stars are visible beside tags and at edges.
std::vector<LatticePlacement> ListPlacements(const std::vector<Feature>& stars,
                                             const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_LATTICE_PLACEMENT_H
