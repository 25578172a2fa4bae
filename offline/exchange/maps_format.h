#ifndef RAYGRID_EXCHANGE_MAPS_FORMAT_H
#define RAYGRID_EXCHANGE_MAPS_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The maps that cv2.remap() takes, of a view.
TableFormat MapsFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MAPS_FORMAT_H
