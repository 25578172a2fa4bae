#ifndef RAYGRID_PACKING_REMAP_QUANTIZATION_H
#define RAYGRID_PACKING_REMAP_QUANTIZATION_H

#include <vector>

#include "packing/node_fitting.h"
#include "packing/remap_blocks.h"
#include "packing/remap_fitting.h"

namespace raygrid {

/// Quantizes vertices of tables with common layout in q12: origin and steps are
/// fitted to the first table's vertices; residuals have the smallest shift for
/// which all used vertices fit. Returns false if there is none.
bool QuantizeVertices(const Blocks& blocks,
                      const std::vector<NodePositions>& vertices,
                      std::vector<RemapTable>* tables);

/// Quantizes the tables' bends to 8 bits, as 4 / N of the bend of an edge of N
/// tiles, with the smallest shift for which all tables fit. Returns false if
/// there is none.
bool QuantizeSagittas(const Blocks& blocks,
                      const std::vector<NodePositions>& nodes,
                      std::vector<RemapTable>* tables);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_QUANTIZATION_H
