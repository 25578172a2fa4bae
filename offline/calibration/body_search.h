#ifndef RAYGRID_CALIBRATION_BODY_SEARCH_H
#define RAYGRID_CALIBRATION_BODY_SEARCH_H

#include <vector>

#include "calibration/bodies.h"
#include "calibration/model_adjustment.h"
#include "evaluation/board_bodies.h"

namespace raygrid {

/// Whether two boards are seen at one instant, by whichever cameras, often
/// enough to tell whether they are fixed to each other.
bool MayTellBodies(const std::vector<Adjusted>& cameras);

/// Bodies of all boards that may be fixed to each other for how often one of
/// the cameras sees them together; their places are not known.
Bodies PossibleBodies(const std::vector<Dataset>& cameras,
                      const Pattern& pattern);

/// How the boards stood to each other that were seen at one instant, in
/// adjustments of boards that move by themselves: each of one camera, or of
/// cameras whose poses are known.
std::vector<BoardPair> CompareBoards(const std::vector<Adjusted>& adjusted,
                                     const Pattern& pattern, int num_threads,
                                     Bodies* bodies);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_BODY_SEARCH_H
