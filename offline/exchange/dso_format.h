#ifndef RAYGRID_EXCHANGE_DSO_FORMAT_H
#define RAYGRID_EXCHANGE_DSO_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// camera.txt of DSO and LSD-SLAM, as in TUM's monocular data set: camera
/// model, image size, and the program's rectification.
Format MakeDsoFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_DSO_FORMAT_H
