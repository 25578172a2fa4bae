#ifndef RAYGRID_EXCHANGE_EXR_H
#define RAYGRID_EXCHANGE_EXR_H

#include <string>
#include <vector>

#include "camera/area.h"

namespace raygrid {

/// Writes an OpenEXR file with 32-bit channels. numbers: interleaved channels,
/// rows from the top.
std::string WriteExr(const ImageSize& size,
                     const std::vector<std::string>& channels,
                     const std::vector<float>& numbers);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_EXR_H
