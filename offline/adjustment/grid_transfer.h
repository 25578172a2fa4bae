#ifndef RAYGRID_ADJUSTMENT_GRID_TRANSFER_H
#define RAYGRID_ADJUSTMENT_GRID_TRANSFER_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/view_jacobian.h"

namespace raygrid {

/// The size of a grid of control points and the layout of its parameters.
struct GridShape {
  int columns = 0, rows = 0, per_node = 0;

  int num_nodes() const { return columns * rows; }
  int num_parameters() const { return num_nodes() * per_node; }
  /// Returns the shape of the grid with twice the knot spacing.
  GridShape Halved() const;
};

/// Infers the shape of a camera's grid from the Jacobian; empty if the model
/// has no grid.
GridShape InferGridShape(const ViewJacobian& jacobian, int num_parameters);

/// Prolongation of fields from a coarse grid to a fine one over the same area:
/// a fine control point gets the value of the coarse spline there.
class GridTransfer {
 public:
  GridTransfer(const GridShape& fine, const GridShape& coarse);

  const GridShape& coarse() const { return coarse_; }

  /// *fine += T coarse, for several fields; the fields of one parameter are
  /// adjacent in memory.
  void AddProlongation(int num_fields, const double* coarse,
                       double* fine) const;
  /// Returns T^T fine.
  Eigen::VectorXd Restrict(int num_fields, const double* fine) const;

  /// Coarse control points and weights of a fine row or column.
  struct Support {
    int first = 0;
    double weight[4];

    double GetWeight(int coarse) const {
      const int index = coarse - first;
      return index < 0 || index > 3 ? 0 : weight[index];
    }
  };
  const std::vector<Support>& columns() const { return columns_; }
  const std::vector<Support>& rows() const { return rows_; }

 private:
  GridShape fine_, coarse_;
  std::vector<Support> columns_, rows_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_GRID_TRANSFER_H
