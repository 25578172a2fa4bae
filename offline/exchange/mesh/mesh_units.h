/// Mesh formats of dewarping engines, one source file each.
#ifndef RAYGRID_EXCHANGE_MESH_MESH_UNITS_H
#define RAYGRID_EXCHANGE_MESH_MESH_UNITS_H

#include <string>
#include <vector>

#include "exchange/table_format.h"

namespace raygrid {

inline TableFormat MakeMeshFormat(const char* name, const char* holds,
                                  const std::vector<std::string>& endings,
                                  const std::vector<std::string>& options,
                                  const MeshUnit* unit) {
  TableFormat format;
  format.name = name;
  format.holds = holds;
  format.endings = endings;
  format.options = options;
  format.mesh_unit = unit;
  return format;
}

TableFormat MakeDw100Format();
TableFormat MakeTiLdcFormat();
TableFormat MakeVpiFormat();
TableFormat MakeRockchipFecFormat();
TableFormat MakeRockchipLdchFormat();
TableFormat MakeHailoFormat();
TableFormat MakeDepthAiMeshFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MESH_MESH_UNITS_H
