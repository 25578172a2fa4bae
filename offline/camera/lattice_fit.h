#ifndef RAYGRID_CAMERA_LATTICE_FIT_H
#define RAYGRID_CAMERA_LATTICE_FIT_H

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "camera/bspline_surface.h"

namespace raygrid {

/// Fits surfaces to values at pixels all over the area, by least squares: one
/// axis after the other, since the pixels are a lattice.
class LatticeFit {
 public:
  explicit LatticeFit(const BSplineSurface& surface);

  const std::vector<Eigen::Vector2d>& pixels() const { return pixels_; }

  /// The control points' values, row by row, from those at the pixels.
  Eigen::VectorXd Of(const Eigen::VectorXd& values) const;

 private:
  static constexpr int kPerCell = 3;  // enough for a single cell

  std::vector<Eigen::Vector2d> pixels_;
  Eigen::SparseMatrix<double> x_, y_;  // a column each pixel along the axis
  Eigen::LLT<Eigen::MatrixXd> x_normal_, y_normal_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_LATTICE_FIT_H
