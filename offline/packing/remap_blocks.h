#ifndef RAYGRID_PACKING_REMAP_BLOCKS_H
#define RAYGRID_PACKING_REMAP_BLOCKS_H

#include <vector>

#include "packing/source_map.h"

namespace raygrid {

/// Sizes of blocks and, where their edges are bent, of the parts that the
/// runtime cuts them into.
struct BlockLayout {
  int block_log2 = 0;
  int part_log2 = 0;  ///< 0: not bent

  bool IsBent() const { return part_log2 != 0; }
  int SmallestLog2() const { return IsBent() ? part_log2 : block_log2; }
};

/// The blocks of a table, and which of them have a source. What is fitted are
/// nodes: the vertices, and behind them as many bends of the edges to the left
/// of each vertex, and of those above it. A bend is how far an edge's middle
/// lies from the straight line.
struct Blocks {
  BlockLayout layout;
  int columns = 0, rows = 0;
  std::vector<bool> used;

  int size_log2() const { return layout.block_log2; }
  int size() const { return 1 << layout.block_log2; }
  bool IsUsed(int i, int j) const { return used[j * columns + i]; }
  int num_vertices() const { return (columns + 1) * (rows + 1); }
  int num_nodes() const { return num_vertices() * (layout.IsBent() ? 3 : 1); }
  int VertexIndex(int i, int j) const { return j * (columns + 1) + i; }
  int LeftBend(int i, int j) const {
    return num_vertices() + VertexIndex(i, j);
  }
  int UpperBend(int i, int j) const {
    return 2 * num_vertices() + VertexIndex(i, j);
  }
};

Blocks CutBlocks(const SourceMap& map, const BlockLayout& layout);

/// Nodes of used blocks; others may be anything.
std::vector<bool> NeededNodes(const Blocks& blocks);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_BLOCKS_H
