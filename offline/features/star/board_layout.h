#ifndef RAYGRID_FEATURES_STAR_BOARD_LAYOUT_H
#define RAYGRID_FEATURES_STAR_BOARD_LAYOUT_H

#include <optional>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/star/lattice_placement.h"

namespace raygrid {

/// Determines the placement of a lattice of stars on a known board from the
/// visible pattern: edges and (parts of) tags. Returns nullopt unless the image
/// matches the board in this placement, and contradicts every other placement
/// for which the board would look different.
std::optional<LatticePlacement> AssignWithLayout(const GreyImage& image,
                                                 const FeatureLattice& lattice,
                                                 const Board& board);

/// Returns whether more than two stars of another board would lie on the board
/// in this placement.
bool AreOnBoard(const std::vector<Feature>& others,
                const FeatureLattice& lattice,
                const LatticePlacement& placement, const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_BOARD_LAYOUT_H
