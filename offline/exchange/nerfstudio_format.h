#ifndef RAYGRID_EXCHANGE_NERFSTUDIO_FORMAT_H
#define RAYGRID_EXCHANGE_NERFSTUDIO_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// transforms.json of nerfstudio and instant-ngp: a camera with its poses.
Format MakeNerfstudioFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_NERFSTUDIO_FORMAT_H
