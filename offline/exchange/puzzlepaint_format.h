#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_FORMAT_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// intrinsics.yaml of the paper's authors' program, puzzlepaint's
/// camera_calibration.
Format PuzzlepaintFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_FORMAT_H
