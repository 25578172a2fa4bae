#ifndef RAYGRID_ADJUSTMENT_COARSE_BASIS_H
#define RAYGRID_ADJUSTMENT_COARSE_BASIS_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

#include "adjustment/grid_transfer.h"
#include "adjustment/normal_equations.h"

namespace raygrid {

constexpr int kCoarsestCells = 12;  ///< maximum along a grid's longer side

/// Basis of a coarse space of all parameters: the coarsest grids of the
/// cameras, camera parameters without a grid, camera poses, and deformation
/// modes of second order.
using CoarseBasis = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// shapes: grid shapes by camera. Points observed in the same poses are assumed
/// to belong to one board.
CoarseBasis MakeCoarseBasis(const ParameterLayout& layout,
                            const std::vector<GridShape>& shapes,
                            const std::vector<ViewJacobian>& jacobians,
                            const std::vector<Eigen::Vector3d>& points);

/// The Jacobian of a residual with respect to the columns of a basis; sparse.
class SparseRow {
 public:
  explicit SparseRow(const CoarseBasis& basis)
      : basis_(basis),
        x_(basis.cols(), 0.0),
        y_(basis.cols(), 0.0),
        is_used_(basis.cols(), 0) {}

  /// Adds the derivative with respect to a parameter.
  void Add(int parameter, const Eigen::Vector2d& derivative) {
    for (CoarseBasis::InnerIterator it(basis_, parameter); it; ++it) {
      if (!is_used_[it.col()]) {
        is_used_[it.col()] = 1;
        used_.push_back(static_cast<int>(it.col()));
      }
      x_[it.col()] += it.value() * derivative.x();
      y_[it.col()] += it.value() * derivative.y();
    }
  }

  /// *with_itself += row^T row, lower triangle only; *with_pose += row^T
  /// J_pose.
  void AddProductsTo(const Eigen::Matrix2Xd& J_pose,
                     Eigen::MatrixXd* with_itself, Eigen::MatrixXd* with_pose) {
    std::sort(used_.begin(), used_.end());
    for (size_t begin = 0; begin < used_.size();) {
      const int count = RunLength(begin), first = used_[begin];
      for (Eigen::Index k = 0; k < J_pose.cols(); ++k)
        AddRun(first, count, J_pose.col(k), &with_pose->coeffRef(first, k));
      // Sums are computed to the end of the run, beyond the triangle.
      for (size_t b = 0; b < begin + count; ++b)
        AddRun(first, count, {x_[used_[b]], y_[used_[b]]},
               &with_itself->coeffRef(first, used_[b]));
      begin += count;
    }
  }

  void Clear() {
    for (const int k : used_) x_[k] = y_[k] = is_used_[k] = 0;
    used_.clear();
  }

 private:
  // Returns the number of consecutive non-zero columns, starting at begin.
  int RunLength(size_t begin) const {
    size_t end = begin + 1;
    while (end < used_.size() && used_[end] == used_[end - 1] + 1) ++end;
    return static_cast<int>(end - begin);
  }

  // sum[k] += (column first + k of the row) times value
  void AddRun(int first, int count, const Eigen::Vector2d& value,
              double* sum) const {
    const double *x = &x_[first], *y = &y_[first];
    const double value_x = value.x(), value_y = value.y();
    for (int k = 0; k < count; ++k) sum[k] += x[k] * value_x + y[k] * value_y;
  }

  const CoarseBasis& basis_;
  std::vector<double> x_, y_;
  std::vector<char> is_used_;
  std::vector<int> used_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_COARSE_BASIS_H
