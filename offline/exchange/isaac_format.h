#ifndef RAYGRID_EXCHANGE_ISAAC_FORMAT_H
#define RAYGRID_EXCHANGE_ISAAC_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The pair of textures that Isaac Sim's cameras look rays and pixels up in.
TableFormat IsaacFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_ISAAC_FORMAT_H
