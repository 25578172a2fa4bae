#ifndef RAYGRID_CAPTURE_CAPTURE_REPORT_H
#define RAYGRID_CAPTURE_CAPTURE_REPORT_H

#include <string>

#include "capture_state.h"

namespace raygrid {

/// Draws a state for a terminal, without colours: the image with the features
/// (o), the view to fill (#), and the predicted uncertainty (. to @, from low
/// to high); then the status, the hint and the progress.
std::string DrawState(const CaptureState& state, int num_columns);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_REPORT_H
