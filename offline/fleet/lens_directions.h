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

/// Computes the directions that explain 99.9 % of the variance about 0 of the
/// inlier rows, at most one per four rows.
LensDirections ComputeDirections(const Eigen::MatrixXd& rows,
                                 const std::vector<bool>& is_usual);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_LENS_DIRECTIONS_H
