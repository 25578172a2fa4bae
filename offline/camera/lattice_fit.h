#ifndef RAYGRID_CAMERA_LATTICE_FIT_H
#define RAYGRID_CAMERA_LATTICE_FIT_H

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "camera/bspline_surface.h"

namespace raygrid {

/// Fits surfaces to values on a lattice of pixels over the area by least
/// squares, separately along each axis.
class LatticeFit {
 public:
  explicit LatticeFit(const BSplineSurface& surface);

  const std::vector<Eigen::Vector2d>& pixels() const { return pixels_; }

  /// Computes the control points' values, row by row, from the pixels' values.
  Eigen::VectorXd Of(const Eigen::VectorXd& values) const;

 private:
  static constexpr int kPerCell = 3;  // enough for a single cell

  std::vector<Eigen::Vector2d> pixels_;
  Eigen::SparseMatrix<double> x_, y_;  // one column per pixel along the axis
  Eigen::LLT<Eigen::MatrixXd> x_normal_, y_normal_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_LATTICE_FIT_H
