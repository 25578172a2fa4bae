#ifndef RAYGRID_CAPTURE_SIDE_BY_SIDE_H
#define RAYGRID_CAPTURE_SIDE_BY_SIDE_H

#include <vector>

#include "capture_page.h"
#include "features/board_view/detection.h"

namespace raygrid {

/// Concatenates pictures horizontally, aligned at the top, with black below.
GreyBuffer ConcatenateHorizontally(
    const std::vector<const GreyImage*>& pictures);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_SIDE_BY_SIDE_H
