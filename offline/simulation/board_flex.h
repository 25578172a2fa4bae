#ifndef RAYGRID_SIMULATION_BOARD_FLEX_H
#define RAYGRID_SIMULATION_BOARD_FLEX_H

#include "dataset/pattern.h"
#include "simulation/random.h"

namespace raygrid {

/// The board as it is bent in one view, at random and smoothly: its features
/// leave its plane by a sum of products of Legendre polynomials, of second to
/// fourth order over the features. Lower orders would be another pose. A mode's
/// deviation falls with the square of its order, as a plate bends.
/// @param rms_m standard deviation of a feature's height, over views and board
Board FlexedBoard(const Board& board, double rms_m, Random* random);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BOARD_FLEX_H
