#ifndef RAYGRID_EXCHANGE_BASALT_FORMAT_H
#define RAYGRID_EXCHANGE_BASALT_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Basalt's calibration.json, which describes a whole rig.
Format MakeBasaltFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_BASALT_FORMAT_H
