#ifndef RAYGRID_PACKING_REMAP_QUANTIZATION_H
#define RAYGRID_PACKING_REMAP_QUANTIZATION_H

#include <vector>

#include "packing/node_fitting.h"
#include "packing/remap_blocks.h"
#include "packing/remap_fitting.h"

namespace raygrid {

/// Vertices of alike tables in q12: origin and steps, which are the closest to
/// the first table's vertices, and residuals with the smallest shift that lets
/// all that are needed of all tables fit. False if none does.
bool QuantizeVertices(const Blocks& blocks,
                      const std::vector<NodePositions>& vertices,
                      std::vector<RemapTable>* tables);

/// Their bends in 8 bits, as 4 / N of how far an edge of N parts bends, with
/// the smallest shift that lets all of all tables fit; false if none does.
bool QuantizeBends(const Blocks& blocks,
                   const std::vector<NodePositions>& nodes,
                   std::vector<RemapTable>* tables);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_QUANTIZATION_H
