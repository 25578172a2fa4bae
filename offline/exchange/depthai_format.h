#ifndef RAYGRID_EXCHANGE_DEPTHAI_FORMAT_H
#define RAYGRID_EXCHANGE_DEPTHAI_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// The calibration of a Luxonis device, as read by CalibrationHandler.
Format MakeDepthAiFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_DEPTHAI_FORMAT_H
