#ifndef RAYGRID_ADJUSTMENT_GRID_TRANSFER_H
#define RAYGRID_ADJUSTMENT_GRID_TRANSFER_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/view_jacobian.h"

namespace raygrid {

/// Nodes in rows, with a camera's parameters node by node.
struct GridShape {
  int columns = 0, rows = 0, per_node = 0;

  int num_nodes() const { return columns * rows; }
  int num_parameters() const { return num_nodes() * per_node; }
  /// The shape of the grid with cells twice as long.
  GridShape Halved() const;
};

/// The shape of the grid that a camera's projections depend on, from what they
/// say of its nodes; nothing in it if there is no grid.
GridShape ShapeOf(const ViewJacobian& jacobian, int num_parameters);

/// Takes fields from a coarse grid over the same area to a fine one: a fine
/// node's value is the coarse spline's at the fine node's place.
class GridTransfer {
 public:
  GridTransfer(const GridShape& fine, const GridShape& coarse);

  const GridShape& coarse() const { return coarse_; }

  /// *fine += T coarse, of several fields, with a parameter's numbers side by
  /// side.
  void AddProlonged(int num_fields, const double* coarse, double* fine) const;
  /// T^T fine
  Eigen::VectorXd Restricted(int num_fields, const double* fine) const;

  /// The coarse nodes of a fine row or column, and their weights.
  struct Support {
    int first = 0;
    double weight[4];

    double WeightOf(int coarse) const {
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
