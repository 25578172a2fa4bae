#ifndef RAYGRID_EXCHANGE_BASALT_FORMAT_H
#define RAYGRID_EXCHANGE_BASALT_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// calibration.json of Basalt, in which a rig is one file.
Format BasaltFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_BASALT_FORMAT_H
