#ifndef RAYGRID_FLEET_PRINCIPAL_DIRECTIONS_H
#define RAYGRID_FLEET_PRINCIPAL_DIRECTIONS_H

#include <Eigen/Core>
#include <vector>

namespace raygrid {

/// Principal directions of rows, and the variance along each.
struct PrincipalDirections {
  Eigen::MatrixXd axes;  ///< columns
  Eigen::VectorXd variances;
};

/// Computes the directions that explain 99.9 % of the variance about 0 of the
/// inlier rows, at most one per four rows.
PrincipalDirections ComputeDirections(const Eigen::MatrixXd& rows,
                                      const std::vector<bool>& is_usual);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_PRINCIPAL_DIRECTIONS_H
