#ifndef RAYGRID_EVALUATION_BOARD_BODIES_H
#define RAYGRID_EVALUATION_BOARD_BODIES_H

#include <string>
#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// How two boards stood to each other that were seen at one instant.
struct BoardPair {
  int first = 0, second = 0;  ///< ids
  int num_instants = 0;       ///< at which both are seen
  bool fixed = false;         ///< to each other, for all that can be told
  /// RMS of the second board's middle and turn, in the frame of the first, from
  /// where they are on the average; and what would be expected of noise.
  double deviation_m = 0, deviation_rad = 0;
  double expected_m = 0, expected_rad = 0;
};

/// "0, 1 and 2".
std::string Enumerated(const std::vector<int>& ids);

/// One sentence on each body, and one on boards that move against others.
std::vector<std::string> BodySentences(const std::vector<BoardBody>& bodies,
                                       const std::vector<BoardPair>& pairs);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_BOARD_BODIES_H
