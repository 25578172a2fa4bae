#ifndef RAYGRID_PACKING_REMAP_BLOCKS_H
#define RAYGRID_PACKING_REMAP_BLOCKS_H

#include <vector>

#include "packing/source_map.h"

namespace raygrid {

/// Sizes of blocks and, if their edges are bent, of the tiles into which the
/// runtime divides them.
struct BlockLayout {
  int block_log2 = 0;
  int part_log2 = 0;  ///< 0: straight edges

  bool HasCurvedEdges() const { return part_log2 != 0; }
  int MinSizeLog2() const { return HasCurvedEdges() ? part_log2 : block_log2; }
};

/// The blocks of a table, and which of them have a source. The fitted nodes are
/// the vertices, followed by the bends of the edges to the left of each vertex,
/// and of the edges above it. The bend of an edge is its sagitta: the
/// displacement of its midpoint from the straight line.
struct Blocks {
  BlockLayout layout;
  int columns = 0, rows = 0;
  std::vector<bool> used;

  int size_log2() const { return layout.block_log2; }
  int size() const { return 1 << layout.block_log2; }
  bool IsUsed(int i, int j) const { return used[j * columns + i]; }
  int num_vertices() const { return (columns + 1) * (rows + 1); }
  int num_nodes() const {
    return num_vertices() * (layout.HasCurvedEdges() ? 3 : 1);
  }
  int VertexIndex(int i, int j) const { return j * (columns + 1) + i; }
  int LeftSagittaIndex(int i, int j) const {
    return num_vertices() + VertexIndex(i, j);
  }
  int UpperSagittaIndex(int i, int j) const {
    return 2 * num_vertices() + VertexIndex(i, j);
  }
};

Blocks SplitIntoBlocks(const SourceMap& map, const BlockLayout& layout);

/// Returns which nodes belong to used blocks; the positions of the other nodes
/// are arbitrary.
std::vector<bool> FindRequiredNodes(const Blocks& blocks);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_BLOCKS_H
