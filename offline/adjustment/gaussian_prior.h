#ifndef RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H
#define RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "adjustment/deformation_modes.h"
#include "camera/bspline_surface.h"
#include "camera/central_generic.h"
#include "camera/parametric_model.h"

namespace raygrid {

/// Directions of a group's parameters along which its prior has a lower
/// precision, or none.
struct UnpenalizedDirections {
  Eigen::MatrixXd directions;  ///< one column per direction
  /// Relative precisions h: cost 0.5 * weight * h * x^2; 0: unpenalized.
  Eigen::VectorXd relative_precisions;
  /// Absolute precisions p, relative to the residual variance: cost
  /// 0.5 * p * x^2.
  Eigen::VectorXd precision_floor;
};

/// Camera parameters with a common prior precision; K is zero for all other
/// parameters. Along the columns of D the prior is nearly unpenalized: the
/// precision matrix is K - R R^T, with R = sqrt(1 - kUnpenalizedScale^2) K D.
/// D^T K D is diagonal: 1 for unpenalized directions, less for those with a
/// remaining precision.
struct PriorGroup {
  static constexpr double kUnpenalizedScale =
      1e-3;  ///< prior scale that remains along D

  Eigen::SparseMatrix<double> precision;  ///< K, over all parameters
  int rank = 0;       ///< rank of K minus unpenalized directions
  double weight = 0;  ///< lambda; set by SetPrecision()
  /// Lower limit of the weight, relative to the residual variance, regardless
  /// of the evidence.
  double precision_floor = 0;
  /// D, scaled so that (I - R D^T) b has the covariance K - R R^T if the random
  /// vector b has K; may have no columns.
  Eigen::MatrixXd free;
  Eigen::MatrixXd unpenalized;  ///< R

  /// Lowers the precision along these directions. Requires `precision` and
  /// `rank`.
  void Unpenalize(const UnpenalizedDirections& added);
  /// Sets the weight of the group. Directions with an absolute precision keep
  /// it, so that their precision relative to the group decreases as the weight
  /// grows.
  void SetPrecision(double new_weight, double residual_variance);

  /// Returns (c - c0)^T (K - R R^T) (c - c0), without lambda.
  double SquaredDistance(const Eigen::VectorXd& difference) const {
    const double distance = difference.dot(precision * difference);
    if (unpenalized.cols() == 0) return distance;
    return distance - (unpenalized.transpose() * difference).squaredNorm();
  }

 private:
  void ApplyRelativePrecisions(const Eigen::VectorXd& relative_precisions);

  UnpenalizedDirections unpenalized_;
  int full_rank_ = 0;
};

/// Projects a random vector with covariance K to one with covariance K - R R^T.
Eigen::VectorXd ProjectOutUnpenalized(const Eigen::MatrixXd& free,
                                      const Eigen::MatrixXd& unpenalized,
                                      const Eigen::VectorXd& random);

/// The base model of a grid. Its parameters are estimated together with the
/// grid, unpenalized except for the precision with which they were fitted to
/// the observations.
struct BaseModel {
  std::shared_ptr<const ParametricModel> model;  ///< nullptr: no base model
  /// Prior precision of each parameter, in units of the inverse residual
  /// variance.
  Eigen::VectorXd precision;
};

/// The prior of a camera's parameters: Gaussian about a base model, with smooth
/// deviations. Added to the cost of the residuals:
///   sum over groups of weight / 2 (c - c0)^T (K - R R^T) (c - c0)
///   + orientation_precision / 2 |G^T (c - c0) - g0|^2
struct CameraPrior {
  Eigen::VectorXd mean;
  std::vector<PriorGroup> groups;

  Eigen::MatrixXd orientation;  ///< G, three columns per field, or empty
  Eigen::VectorXd orientation_difference;  ///< g0; empty: zero
  double orientation_precision = 0;
  BaseModel base_lens = {};                 ///< base model of the prior
  std::vector<BSplineSurface> spread = {};  ///< displacement fields of a fleet

  double Cost(const Eigen::VectorXd& parameters) const;
  /// Returns G^T (c - c0) - g0; empty if G is empty.
  Eigen::VectorXd OrientationError(const Eigen::VectorXd& parameters) const;
};

/// Gaussian priors and their costs: of all cameras, or of none; of the target
/// points about their nominal positions, points_precision / 2 sum |p - p0|^2;
/// and of the deformation coefficients about zero, deformation_precisions / 2
/// f^2 each.
struct GaussianPrior {
  std::vector<CameraPrior> cameras;
  std::vector<Eigen::Vector3d> points_mean;
  double points_precision = 0;
  std::array<double, kNumDeformationOrders> deformation_precisions =
      {};  ///< by DeformationOrder

  double DeformationPrecision(DeformationOrder order) const {
    return deformation_precisions[static_cast<int>(order)];
  }
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H
