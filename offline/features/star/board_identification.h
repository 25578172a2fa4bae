#ifndef RAYGRID_FEATURES_STAR_BOARD_IDENTIFICATION_H
#define RAYGRID_FEATURES_STAR_BOARD_IDENTIFICATION_H

#include <optional>
#include <vector>

#include "appearance/board_appearance.h"
#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/board_view/tag_detection.h"
#include "features/star/lattice_placement.h"

namespace raygrid {

/// A star board with the cells of its tags.
struct TaggedBoard {
  explicit TaggedBoard(const Board& b)
      : board(b), tags(BoardAppearance(b).markers()) {}

  Board board;
  std::vector<PlacedMarker> tags;
};

/// Identifies the board and placement of a lattice of stars from tag cells that
/// are completely or partly in the image; nullopt unless all of these hold:
///   - its stars coincide with stars of the board,
///   - white margins and black borders of the tags are as expected, at least
///     near the stars,
///   - the visible cells of their codes would match equally well by chance at
///     most once in 500 times, counting all placements with a tag there,
///   - no other placement matches nearly as well.
/// Detected tags help to locate cells.
std::optional<LatticePlacement> IdentifyBoard(
    const GreyImage& image, const FeatureLattice& lattice,
    const std::vector<DetectedTag>& detected,
    const std::vector<const TaggedBoard*>& boards);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_BOARD_IDENTIFICATION_H
