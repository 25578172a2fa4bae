#ifndef RAYGRID_EXCHANGE_KEYED_FORMATS_H
#define RAYGRID_EXCHANGE_KEYED_FORMATS_H

#include <vector>

#include "exchange/format.h"

namespace raygrid {

/// Formats of keys and numbers, each described by a table row: key names,
/// layout, parameter order, size, and pose convention. They are read-only.
std::vector<Format> MakeKeyedFormats();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KEYED_FORMATS_H
