#ifndef RAYGRID_EXCHANGE_NERFSTUDIO_FORMAT_H
#define RAYGRID_EXCHANGE_NERFSTUDIO_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// transforms.json of nerfstudio, and of instant-ngp: a camera and its places.
Format NerfstudioFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_NERFSTUDIO_FORMAT_H
