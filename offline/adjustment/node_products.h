#ifndef RAYGRID_ADJUSTMENT_NODE_PRODUCTS_H
#define RAYGRID_ADJUSTMENT_NODE_PRODUCTS_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "adjustment/grid_transfer.h"
#include "adjustment/view_jacobian.h"

namespace raygrid {

/// The camera's block of J^T J: for each control point, per_node x per_node
/// blocks with its 7 x 7 neighbours. Residuals are added in bands of rows,
/// first the even bands, then the odd ones, so that threads do not write to the
/// same blocks.
class NodeProducts {
 public:
  explicit NodeProducts(const GridShape& shape)
      : shape_(shape),
        block_(shape.per_node * shape.per_node),
        values_(static_cast<size_t>(shape.num_nodes()) * 49 * block_, 0.0) {}

  void Add(const ViewJacobian& j, int i) {
    const int k = shape_.per_node;
    const auto J_node = ViewJacobian::Block(j.J_node, i);
    constexpr int kMax = LinearizedProjection::kMaxPerNode;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMax, kMax>
        product = J_node.transpose() * J_node;
    const int base = j.node_parameter(0, i) / k;
    for (int a = 0; a < 16; ++a) {
      const int node = base + a / 4 * shape_.columns + a % 4;
      double* row = &values_[static_cast<size_t>(node) * 49 * block_];
      for (int b = 0; b < 16; ++b) {
        const double weight = j.node_weight(a, i) * j.node_weight(b, i);
        const int partner = (b / 4 - a / 4 + 3) * 7 + b % 4 - a % 4 + 3;
        for (int p = 0; p < block_; ++p)
          row[partner * block_ + p] += weight * product.data()[p];
      }
    }
  }

  void AppendTo(int first,
                std::vector<Eigen::Triplet<double>>* triplets) const {
    const int k = shape_.per_node;
    for (int node = 0; node < shape_.num_nodes(); ++node) {
      for (int partner = 0; partner < 49; ++partner) {
        const int column = node % shape_.columns + partner % 7 - 3;
        const int row = node / shape_.columns + partner / 7 - 3;
        if (column < 0 || column >= shape_.columns || row < 0 ||
            row >= shape_.rows)
          continue;
        const int other = row * shape_.columns + column;
        const double* block =
            &values_[(static_cast<size_t>(node) * 49 + partner) * block_];
        for (int p = 0; p < block_; ++p)
          if (block[p] != 0)
            triplets->emplace_back(first + node * k + p % k,
                                   first + other * k + p / k, block[p]);
      }
    }
  }

 private:
  GridShape shape_;
  int block_;
  std::vector<double> values_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NODE_PRODUCTS_H
