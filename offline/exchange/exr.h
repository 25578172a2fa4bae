#ifndef RAYGRID_EXCHANGE_EXR_H
#define RAYGRID_EXCHANGE_EXR_H

#include <string>
#include <vector>

#include "camera/area.h"

namespace raygrid {

/// An OpenEXR file of channels of 32 bits, of which each pixel has one number
/// after another; rows from the top.
std::string WriteExr(const ImageSize& size,
                     const std::vector<std::string>& channels,
                     const std::vector<float>& numbers);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_EXR_H
