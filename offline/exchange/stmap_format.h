#ifndef RAYGRID_EXCHANGE_STMAP_FORMAT_H
#define RAYGRID_EXCHANGE_STMAP_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// A view's source positions as fractions of the image, for compositing.
TableFormat MakeStMapFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_STMAP_FORMAT_H
