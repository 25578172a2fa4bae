#ifndef RAYGRID_EXCHANGE_INTEL_HEX_FORMAT_H
#define RAYGRID_EXCHANGE_INTEL_HEX_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// A blob for an address in flash, as Intel HEX for flash programmers.
TableFormat MakeIntelHexFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_INTEL_HEX_FORMAT_H
