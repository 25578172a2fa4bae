#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_PATTERN_FORMAT_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_PATTERN_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Pattern file of the generic model's authors: a star board without a camera.
Format MakePuzzlepaintPatternFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_PATTERN_FORMAT_H
