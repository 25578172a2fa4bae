#ifndef RAYGRID_EXCHANGE_C_ARRAY_FORMAT_H
#define RAYGRID_EXCHANGE_C_ARRAY_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// A blob as a C or C++ array.
TableFormat MakeCArrayFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_C_ARRAY_FORMAT_H
