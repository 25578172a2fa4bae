/// Guesses of boards with markers from what an image shows of them.
#ifndef RAYGRID_FEATURES_MARKER_BOARD_GUESS_H
#define RAYGRID_FEATURES_MARKER_BOARD_GUESS_H

#include <optional>
#include <string>
#include <tuple>

#include "dataset/pattern.h"
#include "features/board_view/detection.h"

namespace raygrid {

/// A board guessed from one image; columns and rows as in pattern.yaml, only
/// those that are seen.
struct Guess {
  std::string kind;
  /// The dictionary of a ChArUco board, without its number of markers; an
  /// AprilGrid's family, likewise.
  std::string dictionary;
  bool is_mirrored = false;
  int columns = 0, rows = 0;
  int max_marker = 0;
  bool is_negative = false;  ///< white on black
  /// AprilGrid: as in Board.
  bool has_corner_squares = true;
  int border_cells = 2;
  bool is_numbered_from_top = false;

  bool HasMarkers() const { return !dictionary.empty(); }
  /// The key that guesses from images of one board have in common: rows of
  /// markers may be hidden.
  auto Key() const {
    return std::make_tuple(kind, dictionary, is_mirrored, is_negative, columns,
                           HasMarkers() ? 0 : rows, border_cells,
                           is_numbered_from_top);
  }
};

/// Whether the markers are of the board's kind; if they are on boards of one
/// kind.
bool HasRequestedMarkers(const Guess& guess, const Board& asked);
/// Whether the board may be the one that is guessed.
bool MatchesRequest(const Guess& guess, const Board& asked);

/// The layout of markers that those in the image confirm best: of dictionaries
/// and families of any name, the asked one first. Nothing if there are too few,
/// or they contradict each other.
std::optional<Guess> GuessCharuco(const GreyImage& image, const Board& asked);
std::optional<Guess> GuessAprilGrid(const GreyImage& image, const Board& asked);

/// The name of a dictionary of ArUco's own with its number of markers, as small
/// as holds a marker; others as they are.
std::string DictionaryName(const std::string& name, int max_marker);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_MARKER_BOARD_GUESS_H
