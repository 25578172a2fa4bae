#ifndef RAYGRID_FEATURES_STAR_BOARD_LAYOUT_H
#define RAYGRID_FEATURES_STAR_BOARD_LAYOUT_H

#include <optional>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/star/lattice_placement.h"

namespace raygrid {

/// The placement of a lattice of stars on a board that is known to be the one,
/// told by all that is seen of the board: its edges, the place of its tags, and
/// the visible parts of them. Nothing unless the board looks as it must, and
/// each other placement is refuted: where it would look otherwise, it does not
/// look so.
std::optional<LatticePlacement> AssignByLayout(const GreyImage& image,
                                               const FeatureLattice& lattice,
                                               const Board& board);

/// Whether stars of another board would lie on a board that is so placed.
bool AreOnBoard(const std::vector<Feature>& others,
                const FeatureLattice& lattice,
                const LatticePlacement& placement, const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_BOARD_LAYOUT_H
