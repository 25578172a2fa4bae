#ifndef RAYGRID_EXCHANGE_MRCAL_FORMAT_H
#define RAYGRID_EXCHANGE_MRCAL_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// mrcal's .cameramodel: a Python dictionary of a camera with its pose.
Format MakeMrcalFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MRCAL_FORMAT_H
