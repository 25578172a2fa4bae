#ifndef RAYGRID_EXCHANGE_LIBCAMERA_FORMAT_H
#define RAYGRID_EXCHANGE_LIBCAMERA_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// The Dewarp module of libcamera's tuning files.
Format MakeLibcameraFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_LIBCAMERA_FORMAT_H
