#ifndef RAYGRID_EXCHANGE_KALIBR_TARGET_FORMAT_H
#define RAYGRID_EXCHANGE_KALIBR_TARGET_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Kalibr's target file: a board without a camera.
Format MakeKalibrTargetFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KALIBR_TARGET_FORMAT_H
