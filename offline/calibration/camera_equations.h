#ifndef RAYGRID_CALIBRATION_CAMERA_EQUATIONS_H
#define RAYGRID_CALIBRATION_CAMERA_EQUATIONS_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/adjusted.h"

namespace raygrid {

/// The normal equations of the camera by one view, with the view's pose
/// eliminated: its weighted squared residuals are squares + 2 gradient x
/// + x hessian x where the camera's parameters change by x.
struct CameraEquations {
  std::string image;
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  double squares = 0;
  int count = 0;  ///< of valid residuals

  double At(const Eigen::VectorXd& change) const {
    return squares + change.dot(2 * gradient + hessian * change);
  }
};

/// Of each view with valid residuals, by a camera of few parameters. Points are
/// fixed.
std::vector<CameraEquations> EquationsByView(const Adjusted& adjusted,
                                             double huber_px, int num_threads);

/// The change that leaves the least squares of summed equations.
Eigen::VectorXd LeastSquaresChange(Eigen::MatrixXd hessian,
                                   const Eigen::VectorXd& gradient,
                                   double ridge);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_EQUATIONS_H
