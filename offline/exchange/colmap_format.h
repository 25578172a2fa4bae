#ifndef RAYGRID_EXCHANGE_COLMAP_FORMAT_H
#define RAYGRID_EXCHANGE_COLMAP_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// COLMAP's cameras.txt and cameras.bin; for a rig with the adjacent rigs.txt
/// or rigs.bin.
Format MakeColmapFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_COLMAP_FORMAT_H
