#ifndef RAYGRID_EXCHANGE_KEYED_FORMATS_H
#define RAYGRID_EXCHANGE_KEYED_FORMATS_H

#include <vector>

#include "exchange/format.h"

namespace raygrid {

/// Formats that are keys and numbers and no more, as a table says them: names,
/// layout, order, size, and what their poses mean. They are read alone.
std::vector<Format> KeyedFormats();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KEYED_FORMATS_H
