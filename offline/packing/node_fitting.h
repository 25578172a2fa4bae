#ifndef RAYGRID_PACKING_NODE_FITTING_H
#define RAYGRID_PACKING_NODE_FITTING_H

#include <Eigen/Core>
#include <vector>

#include "packing/remap_blocks.h"
#include "packing/source_map.h"

namespace raygrid {

/// Sums over the pixels of each cell whose sources are known. They are all that
/// a least-squares fit needs: positions in a block are bilinear within a cell.
class CellSums {
 public:
  /// The sums of 1, x, y, x y of a cell's pixel (x, y) times its source, in
  /// pixels.
  using Sources = Eigen::Matrix<double, 4, 2, Eigen::RowMajor>;
  /// The sums of 1, x, y, x y times each other.
  using Products = Eigen::Matrix4d;

  CellSums(const SourceMap& map, int num_threads);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const Sources& sources(int column, int row) const {
    return sources_[row * columns_ + column];
  }
  const Products& products(int column, int row) const {
    return products_[which_[row * columns_ + column]];
  }
  /// Whether no source is unknown.
  bool IsWhole(int column, int row) const {
    return which_[row * columns_ + column] == kWhole;
  }
  const Products& whole_products() const { return products_[kWhole]; }

 private:
  static constexpr int kWhole = 0;

  int columns_, rows_;
  std::vector<Sources> sources_;
  std::vector<Products> products_;
  std::vector<int> which_;  // of the products
};

/// The source of each vertex and the bends, in pixels, row by row of nodes.
using NodePositions = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// The nodes, of used blocks only, that give about the least largest error.
NodePositions FitNodes(const SourceMap& map, const CellSums& sums,
                       const Blocks& blocks);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_NODE_FITTING_H
