#ifndef RAYGRID_EXCHANGE_MAPS_FORMAT_H
#define RAYGRID_EXCHANGE_MAPS_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The maps of a view for cv2.remap().
TableFormat MakeMapsFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MAPS_FORMAT_H
