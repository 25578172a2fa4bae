/// Guesses the layout of boards with markers from an image.
#ifndef RAYGRID_FEATURES_MARKER_BOARD_GUESS_H
#define RAYGRID_FEATURES_MARKER_BOARD_GUESS_H

#include <optional>
#include <string>
#include <tuple>

#include "dataset/pattern.h"
#include "features/board_view/detection.h"

namespace raygrid {

/// A board guessed from one image; columns and rows as in pattern.yaml, only
/// the visible ones.
struct Guess {
  std::string kind;
  /// Dictionary of a ChArUco board, without its number of markers, or family of
  /// an AprilGrid.
  std::string dictionary;
  bool is_mirrored = false;
  int columns = 0, rows = 0;
  int max_marker = 0;
  bool is_negative = false;  ///< white on black
  /// For AprilGrids, as in Board.
  bool has_corner_squares = true;
  int border_cells = 2;
  bool is_numbered_from_top = false;

  bool HasMarkers() const { return !dictionary.empty(); }
  /// Key with equal values for guesses from different images of one board: rows
  /// of markers may be hidden.
  auto Key() const {
    return std::make_tuple(kind, dictionary, is_mirrored, is_negative, columns,
                           HasMarkers() ? 0 : rows, border_cells,
                           is_numbered_from_top);
  }
};

/// Whether the markers, if any, are of the requested board's kind.
bool HasRequestedMarkers(const Guess& guess, const Board& known_board);
/// Whether the guess is consistent with the requested board.
bool MatchesRequest(const Guess& guess, const Board& known_board);

/// Returns the layout that the markers in the image support best, of all
/// dictionaries and families, the requested one first. nullopt if markers are
/// too few or inconsistent.
std::optional<Guess> GuessCharuco(const GreyImage& image,
                                  const Board& known_board);
std::optional<Guess> GuessAprilGrid(const GreyImage& image,
                                    const Board& known_board);

/// Returns the name of one of ArUco's dictionaries with the smallest number of
/// markers that includes max_marker; other names are unchanged.
std::string DictionaryName(const std::string& name, int max_marker);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_MARKER_BOARD_GUESS_H
