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

/// A star board with its tags' cells.
struct TaggedBoard {
  explicit TaggedBoard(const Board& b)
      : board(b), tags(BoardAppearance(b).markers()) {}

  Board board;
  std::vector<PlacedMarker> tags;
};

/// Tells from the cells of tags, wholly or partly in the image, on which board
/// a lattice of stars lies and where; nothing unless all of these hold:
///   - its stars lie where the board has some,
///   - the tags' white margins and black borders are as they must be, near the
///     stars at least,
///   - the cells of their codes that are seen would agree as well by chance
///     once in 500 times, all placements with a tag there counted,
///   - no other placement agrees nearly as well.
/// Detected tags help to see where cells are.
std::optional<LatticePlacement> IdentifyBoard(
    const GreyImage& image, const FeatureLattice& lattice,
    const std::vector<DetectedTag>& detected,
    const std::vector<const TaggedBoard*>& boards);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_BOARD_IDENTIFICATION_H
