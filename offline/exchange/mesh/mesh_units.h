/// The formats of dewarping units, one file each.
#ifndef RAYGRID_EXCHANGE_MESH_MESH_UNITS_H
#define RAYGRID_EXCHANGE_MESH_MESH_UNITS_H

#include "exchange/table_format.h"

namespace raygrid {

TableFormat Dw100Format();
TableFormat TiLdcFormat();
TableFormat VpiFormat();
TableFormat RockchipFecFormat();
TableFormat RockchipLdchFormat();
TableFormat HailoFormat();
TableFormat DepthAiMeshFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MESH_MESH_UNITS_H
