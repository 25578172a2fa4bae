#ifndef RAYGRID_EXCHANGE_MRCAL_CORNERS_FORMAT_H
#define RAYGRID_EXCHANGE_MRCAL_CORNERS_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// corners.vnl of mrcal and mrgingham: board corners without a camera.
Format MakeMrcalCornersFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MRCAL_CORNERS_FORMAT_H
