#ifndef RAYGRID_EXCHANGE_KEYED_WRITER_H
#define RAYGRID_EXCHANGE_KEYED_WRITER_H

#include <string>

#include "exchange/format.h"
#include "exchange/keyed_table.h"

namespace raygrid {

/// The text of a file of a format in the table, one that has an ending. Throws
/// InputError for cameras that it has no place for.
std::string WriteKeyed(const KeyedFormat& format, const WriteRequest& request);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KEYED_WRITER_H
