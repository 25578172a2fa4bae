#ifndef RAYGRID_EXCHANGE_KALIBR_FORMAT_H
#define RAYGRID_EXCHANGE_KALIBR_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Kalibr's camchain: a camera, or a rig as a chain of relative poses.
Format MakeKalibrFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KALIBR_FORMAT_H
