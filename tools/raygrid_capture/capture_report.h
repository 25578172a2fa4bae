#ifndef RAYGRID_CAPTURE_CAPTURE_REPORT_H
#define RAYGRID_CAPTURE_CAPTURE_REPORT_H

#include <string>

#include "capture_state.h"

namespace raygrid {

/// Lines for a terminal, without colours: the image with the board (o), the
/// view to fill (#), and how well places are known (. to @, the less the
/// darker); then the word, the hint and how far it is.
std::string DrawState(const CaptureState& state, int num_columns);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_REPORT_H
