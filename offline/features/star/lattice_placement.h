#ifndef RAYGRID_FEATURES_STAR_LATTICE_PLACEMENT_H
#define RAYGRID_FEATURES_STAR_LATTICE_PLACEMENT_H

#include <Eigen/Core>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

/// The placement of a lattice of stars on a board: turned by quarters, then
/// moved.
struct LatticePlacement {
  int board = 0;  ///< its number among those asked about
  int quarter_turns = 0;
  int column = 0, row = 0;  ///< of the lattice's place (0, 0)

  Eigen::Vector2i OnBoard(int lattice_column, int lattice_row) const;
  Eigen::Vector2d OnBoard(const Eigen::Vector2d& on_lattice) const;
  Eigen::Vector2d OnLattice(const Eigen::Vector2d& on_board) const;
};

/// All at which a lattice's stars lie where the board has some, but for a few:
/// beside tags and along the edges half stars are seen.
std::vector<LatticePlacement> ListPlacements(const std::vector<Feature>& stars,
                                             const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_LATTICE_PLACEMENT_H
