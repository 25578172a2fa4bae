#include "camera/lattice_fit.h"

namespace raygrid {

LatticeFit::LatticeFit(const BSplineSurface& surface)
    : pixels_(surface.SamplePixels(kPerCell)),
      x_(surface.columns(), (surface.columns() - 3) * kPerCell + 1),
      y_(surface.rows(), (surface.rows() - 3) * kPerCell + 1) {
  for (Eigen::Index i = 0; i < x_.cols(); ++i) {
    const SplineSupport support = surface.Support(pixels_[i]);
    for (int k = 0; k < 4; ++k)
      x_.insert(support.column + k, i) = support.wx[k];
  }
  for (Eigen::Index j = 0; j < y_.cols(); ++j) {
    const SplineSupport support = surface.Support(pixels_[j * x_.cols()]);
    for (int k = 0; k < 4; ++k) y_.insert(support.row + k, j) = support.wy[k];
  }
  x_normal_.compute(Eigen::MatrixXd(x_ * x_.transpose()));
  y_normal_.compute(Eigen::MatrixXd(y_ * y_.transpose()));
}

Eigen::VectorXd LatticeFit::Of(const Eigen::VectorXd& values) const {
  const Eigen::Map<const Eigen::MatrixXd> lattice(values.data(), x_.cols(),
                                                  y_.cols());
  const Eigen::MatrixXd along_x = x_normal_.solve(x_ * lattice);
  const Eigen::MatrixXd points =
      y_normal_.solve(y_ * along_x.transpose()).transpose();
  return Eigen::Map<const Eigen::VectorXd>(points.data(), points.size());
}

}  // namespace raygrid
