#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_FORMAT_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// intrinsics.yaml of puzzlepaint's camera_calibration, the program of the
/// paper's authors.
Format MakePuzzlepaintFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_FORMAT_H
