#ifndef RAYGRID_EXCHANGE_RAYS_FORMAT_H
#define RAYGRID_EXCHANGE_RAYS_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The ray of each pixel, as numpy arrays.
TableFormat MakeRaysFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_RAYS_FORMAT_H
