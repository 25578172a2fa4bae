#ifndef RAYGRID_EXCHANGE_STMAP_FORMAT_H
#define RAYGRID_EXCHANGE_STMAP_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// A view's sources as parts of the image, for compositing programs.
TableFormat StMapFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_STMAP_FORMAT_H
