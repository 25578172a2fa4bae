#ifndef RAYGRID_PACKING_NODE_FITTING_H
#define RAYGRID_PACKING_NODE_FITTING_H

#include <Eigen/Core>
#include <vector>

#include "packing/remap_blocks.h"
#include "packing/source_map.h"

namespace raygrid {

/// Moments of each cell over its pixels with a source. They suffice for a
/// least-squares fit, because positions are bilinear within a cell.
class CellSums {
 public:
  /// Sums of 1, x, y, x y of a cell's pixels (x, y), times their source (px).
  using Sources = Eigen::Matrix<double, 4, 2, Eigen::RowMajor>;
  /// Sums of products of 1, x, y, x y with each other.
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
  /// Whether all pixels of a cell have a source.
  bool IsWhole(int column, int row) const {
    return which_[row * columns_ + column] == kWhole;
  }
  const Products& interior_products() const { return products_[kWhole]; }

 private:
  static constexpr int kWhole = 0;

  int columns_, rows_;
  std::vector<Sources> sources_;
  std::vector<Products> products_;
  std::vector<int> which_;  // index into products
};

/// Source of each vertex, and bends of edges, in px, row by row.
using NodePositions = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Fits the nodes of used blocks to approximately minimize the maximum error.
NodePositions FitNodes(const SourceMap& map, const CellSums& sums,
                       const Blocks& blocks);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_NODE_FITTING_H
