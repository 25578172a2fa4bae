#ifndef RAYGRID_SIMULATION_BOARD_DEFORMATION_H
#define RAYGRID_SIMULATION_BOARD_DEFORMATION_H

#include "dataset/pattern.h"
#include "simulation/random.h"

namespace raygrid {

/// Returns the board with a random smooth per-view deformation: out-of-plane
/// products of Legendre polynomials of orders two to four over the features.
/// Lower orders would be a change of pose. A mode's standard deviation
/// decreases with its squared order, as for a bent plate.
/// @param rms_m standard deviation of a feature's height, over views and board
Board DeformBoard(const Board& board, double rms_m, Random* random);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BOARD_DEFORMATION_H
