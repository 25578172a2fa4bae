#include "adjustment/grid_transfer.h"

#include "camera/bspline_surface.h"

namespace raygrid {
namespace {

int HalvedCount(int count) { return (count - 3 + 1) / 2 + 3; }

// Returns the spline weights along one axis. Fine control point i is i - 1
// cells from the edge of the area.
std::vector<GridTransfer::Support> Supports(int fine, int coarse) {
  const double extent = fine - 3;
  const BSplineSurface spline({0, 0, extent, 1}, coarse, 4);
  std::vector<GridTransfer::Support> supports(fine);
  for (int i = 0; i < fine; ++i) {
    const SplineSupport at = spline.Support({i - 1, 0});
    supports[i].first = at.column;
    for (int k = 0; k < 4; ++k) supports[i].weight[k] = at.wx[k];
  }
  return supports;
}

}  // namespace

GridShape GridShape::Halved() const {
  return {HalvedCount(columns), HalvedCount(rows), per_node};
}

GridShape InferGridShape(const ViewJacobian& jacobian, int num_parameters) {
  GridShape shape;
  if (jacobian.num_nodes != 16 || jacobian.count() == 0) return shape;
  const auto first = jacobian.node_parameter.col(0);
  shape.per_node = jacobian.num_per_node;
  shape.columns = (first[4] - first[0]) / shape.per_node;
  shape.rows =
      (num_parameters - jacobian.num_global) / shape.per_node / shape.columns;
  return shape;
}

GridTransfer::GridTransfer(const GridShape& fine, const GridShape& coarse)
    : fine_(fine),
      coarse_(coarse),
      columns_(Supports(fine.columns, coarse.columns)),
      rows_(Supports(fine.rows, coarse.rows)) {}

void GridTransfer::AddProlongation(int num_fields, const double* coarse,
                                   double* fine) const {
  const int k = fine_.per_node * num_fields;
  const int coarse_width = coarse_.columns * k;
  std::vector<double> row(coarse_width);
  for (int j = 0; j < fine_.rows; ++j) {
    const double* from = coarse + rows_[j].first * coarse_width;
    for (int x = 0; x < coarse_width; ++x) {
      row[x] = 0;
      for (int m = 0; m < 4; ++m)
        row[x] += rows_[j].weight[m] * from[m * coarse_width + x];
    }
    for (int i = 0; i < fine_.columns; ++i)
      for (int n = 0; n < 4; ++n)
        for (int p = 0; p < k; ++p)
          fine[(j * fine_.columns + i) * k + p] +=
              columns_[i].weight[n] * row[(columns_[i].first + n) * k + p];
  }
}

Eigen::VectorXd GridTransfer::Restrict(int num_fields,
                                       const double* fine) const {
  const int k = fine_.per_node * num_fields;
  const int coarse_width = coarse_.columns * k;
  Eigen::VectorXd coarse =
      Eigen::VectorXd::Zero(coarse_.num_parameters() * num_fields);
  std::vector<double> row(coarse_width);
  for (int j = 0; j < fine_.rows; ++j) {
    row.assign(coarse_width, 0);
    for (int i = 0; i < fine_.columns; ++i)
      for (int n = 0; n < 4; ++n)
        for (int p = 0; p < k; ++p)
          row[(columns_[i].first + n) * k + p] +=
              columns_[i].weight[n] * fine[(j * fine_.columns + i) * k + p];
    double* to = coarse.data() + rows_[j].first * coarse_width;
    for (int m = 0; m < 4; ++m)
      for (int x = 0; x < coarse_width; ++x)
        to[m * coarse_width + x] += rows_[j].weight[m] * row[x];
  }
  return coarse;
}

}  // namespace raygrid
