#include "packing/remap_blocks.h"

namespace raygrid {

Blocks SplitIntoBlocks(const SourceMap& map, const BlockLayout& layout) {
  Blocks blocks;
  blocks.layout = layout;
  blocks.columns = ((map.width - 1) >> layout.block_log2) + 1;
  blocks.rows = ((map.height - 1) >> layout.block_log2) + 1;
  blocks.used.assign(blocks.columns * blocks.rows, false);
  const int cells_log2 = layout.block_log2 - SourceMap::kCellLog2;
  const auto get_block = [&](int column, int row) {
    return (row >> cells_log2) * blocks.columns + (column >> cells_log2);
  };
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column)
      if (map.cell(column, row) >= SourceMap::Cell::kPartial &&
          !map.is_hidden[row * map.columns + column])
        blocks.used[get_block(column, row)] = true;
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column)
      if (map.is_cut_off[row * map.columns + column])
        blocks.used[get_block(column, row)] = false;
  return blocks;
}

std::vector<bool> FindRequiredNodes(const Blocks& blocks) {
  std::vector<bool> needed(blocks.num_nodes(), false);
  for (int j = 0; j < blocks.rows; ++j) {
    for (int i = 0; i < blocks.columns; ++i) {
      if (!blocks.IsUsed(i, j)) continue;
      for (const int dj : {0, 1})
        for (const int di : {0, 1})
          needed[blocks.VertexIndex(i + di, j + dj)] = true;
      if (!blocks.layout.HasCurvedEdges()) continue;
      for (const int d : {0, 1}) {
        needed[blocks.LeftSagittaIndex(i + 1, j + d)] = true;
        needed[blocks.UpperSagittaIndex(i + d, j + 1)] = true;
      }
    }
  }
  return needed;
}

}  // namespace raygrid
