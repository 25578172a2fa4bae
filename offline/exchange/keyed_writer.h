#ifndef RAYGRID_EXCHANGE_KEYED_WRITER_H
#define RAYGRID_EXCHANGE_KEYED_WRITER_H

#include <string>

#include "exchange/format.h"
#include "exchange/keyed_table.h"

namespace raygrid {

/// Formats a file of a keyed format, which must have an extension. Throws
/// InputError for cameras that the format cannot represent.
std::string WriteKeyed(const KeyedFormat& format, const WriteRequest& request);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KEYED_WRITER_H
