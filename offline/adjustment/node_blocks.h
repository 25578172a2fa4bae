#ifndef RAYGRID_ADJUSTMENT_NODE_BLOCKS_H
#define RAYGRID_ADJUSTMENT_NODE_BLOCKS_H

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SparseCore>

#include "adjustment/grid_transfer.h"
#include "adjustment/normal_equations.h"

namespace raygrid {

/// Inverts square blocks that are stored side by side.
template <typename Block>
void InvertBlocks(Eigen::MatrixXd* blocks) {
  const Eigen::Index k = blocks->rows();
  for (Eigen::Index i = 0; i < blocks->cols(); i += k) {
    const Block block = blocks->middleCols(i, k);
    blocks->middleCols(i, k) = block.inverse();
  }
}

/// InvertBlocks() for control points with any number of parameters.
inline void InvertNodeBlocks(Eigen::MatrixXd* blocks) {
  // A coarse control point without any support has no entries.
  for (Eigen::Index i = 0; i < blocks->cols(); ++i)
    (*blocks)(i % blocks->rows(), i) += kDampingFloor;
  if (blocks->rows() == 2)
    InvertBlocks<Eigen::Matrix2d>(blocks);
  else
    InvertBlocks<Eigen::MatrixXd>(blocks);
}

/// *product += blocks * vectors, block by block; corresponding entries of the
/// vectors are adjacent in memory.
template <int kNum>
void AddBlockProduct(const Eigen::MatrixXd& blocks, const double* vectors,
                     double* product) {
  const Eigen::Index k = blocks.rows();
  for (Eigen::Index i = 0; i < blocks.cols(); ++i)
    for (Eigen::Index p = 0; p < k; ++p)
      for (Eigen::Index n = 0; n < kNum; ++n)
        product[(i / k * k + p) * kNum + n] +=
            blocks(p, i) * vectors[i * kNum + n];
}

/// Computes the diagonal blocks of T^T A T: T prolongs to the grid of this
/// shape, whose parameters begin with the first of A.
inline Eigen::MatrixXd CoarseBlocks(const GridShape& shape,
                                    const GridTransfer& transfer, int first,
                                    const Eigen::SparseMatrix<double>& a) {
  const int k = shape.per_node;
  Eigen::MatrixXd blocks =
      Eigen::MatrixXd::Zero(k, transfer.coarse().num_parameters());
  for (int i = 0; i < shape.num_parameters(); ++i) {
    const int node = i / k;
    const auto& x = transfer.columns()[node % shape.columns];
    const auto& y = transfer.rows()[node / shape.columns];
    for (Eigen::SparseMatrix<double>::InnerIterator it(a, first + i); it;
         ++it) {
      const int row = static_cast<int>(it.row()) - first;
      const auto& other_x = transfer.columns()[row / k % shape.columns];
      const auto& other_y = transfer.rows()[row / k / shape.columns];
      double wx[4];
      for (int n = 0; n < 4; ++n)
        wx[n] = x.weight[n] * other_x.GetWeight(x.first + n);
      for (int m = 0; m < 4; ++m) {
        const double wy =
            it.value() * y.weight[m] * other_y.GetWeight(y.first + m);
        if (wy == 0) continue;
        const int coarse = (y.first + m) * transfer.coarse().columns + x.first;
        for (int n = 0; n < 4; ++n)
          blocks(row % k, (coarse + n) * k + i % k) += wy * wx[n];
      }
    }
  }
  return blocks;
}

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NODE_BLOCKS_H
