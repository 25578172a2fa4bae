#ifndef RAYGRID_FLEET_LENS_DIRECTIONS_H
#define RAYGRID_FLEET_LENS_DIRECTIONS_H

#include <Eigen/Core>
#include <vector>

namespace raygrid {

/// Principal directions of rows, and the variance along each.
struct LensDirections {
  Eigen::MatrixXd axes;  ///< columns
  Eigen::VectorXd variances;
};

/// The directions that make up 99.9 % of the variance about 0 of the usual
/// rows, at most one for four of these.
LensDirections DirectionsOf(const Eigen::MatrixXd& rows,
                            const std::vector<bool>& is_usual);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_LENS_DIRECTIONS_H
