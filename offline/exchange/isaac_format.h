#ifndef RAYGRID_EXCHANGE_ISAAC_FORMAT_H
#define RAYGRID_EXCHANGE_ISAAC_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The pair of lookup textures (rays, pixels) for cameras of Isaac Sim.
TableFormat MakeIsaacFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_ISAAC_FORMAT_H
