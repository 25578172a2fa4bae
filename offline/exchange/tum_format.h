#ifndef RAYGRID_EXCHANGE_TUM_FORMAT_H
#define RAYGRID_EXCHANGE_TUM_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The trajectory of a camera, for trajectory evaluation tools.
TableFormat MakeTumFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_TUM_FORMAT_H
