#ifndef RAYGRID_EXCHANGE_KEYED_FORMATS_H
#define RAYGRID_EXCHANGE_KEYED_FORMATS_H

#include <vector>

#include "exchange/format.h"

namespace raygrid {

/// Makes the formats that consist of keys and numbers. Each is described by one
/// row of a table: key names, layout, parameter order, image size, and pose
/// convention. They are read-only.
std::vector<Format> MakeKeyedFormats();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KEYED_FORMATS_H
