#ifndef RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H
#define RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "adjustment/board_flex.h"
#include "camera/bspline_surface.h"
#include "camera/central_generic.h"
#include "camera/parametric_model.h"

namespace raygrid {

/// Directions in which the parameters of a group are freer than it holds them.
struct FreeDirections {
  Eigen::MatrixXd directions;  ///< a column each
  /// Their factors x cost hold / 2 x^2, times the group's weight; 0 is free.
  Eigen::VectorXd holds;
  /// And firmness / 2 x^2, times the residuals' variance, whatever the weight.
  Eigen::VectorXd firmness;
};

/// Parameters of a camera that scatter alike: K is zero for all others. In a
/// few directions D they are as good as free, or hardly held: what counts is
/// K - R R^T, with R = sqrt(1 - kHeld^2) K D. D^T K D is diagonal: 1 for what
/// is free, less for what is held a little.
struct PriorGroup {
  static constexpr double kHeld =
      1e-3;  ///< of a departure, in these directions

  Eigen::SparseMatrix<double> precision;  ///< K, over all parameters
  int rank = 0;                           ///< of K, less what is rather free
  double weight = 0;                      ///< by SetWeight()
  /// The weight is at least so many of the residuals' variance, however far the
  /// parameters depart.
  double firmness = 0;
  /// D, scaled so that (I - R D^T) b has the covariance K - R R^T if the random
  /// vector b has K; may have no columns.
  Eigen::MatrixXd free;
  Eigen::MatrixXd freed;  ///< R

  /// Frees directions, once the group has its precision and rank.
  void Free(const FreeDirections& freer);
  /// Directions that are held by their firmness are the freer beside the rest
  /// the more the group weighs.
  void SetWeight(double new_weight, double residual_variance);

  /// (c - c0)^T (K - R R^T) (c - c0), without the weight.
  double SquaredDistance(const Eigen::VectorXd& difference) const {
    const double distance = difference.dot(precision * difference);
    if (freed.cols() == 0) return distance;
    return distance - (freed.transpose() * difference).squaredNorm();
  }

 private:
  void HoldFree(const Eigen::VectorXd& holds);

  FreeDirections freer_;
  int full_rank_ = 0;
};

/// Turns a random vector of covariance K into one of covariance K - R R^T.
Eigen::VectorXd WithoutFree(const Eigen::MatrixXd& free,
                            const Eigen::MatrixXd& freed,
                            const Eigen::VectorXd& random);

/// The parametric camera that a grid lies around. Its parameters are estimated
/// together with the grid: they are unpenalized but for what held them when the
/// camera was fitted to the observations.
struct BaseLens {
  std::shared_ptr<const ParametricModel> model;  ///< nullptr: of no such model
  /// Of each parameter, in units of the inverse residual variance.
  Eigen::VectorXd precision;
};

/// The belief about a camera's parameters before the observations: they lie
/// around a parametric lens, with smooth differences. The prior costs, beside
/// the residuals:
///   sum over groups of weight / 2 (c - c0)^T (K - R R^T) (c - c0)
///   + orientation_weight / 2 |G^T (c - c0) - g0|^2
struct CameraPrior {
  Eigen::VectorXd mean;
  std::vector<PriorGroup> groups;

  Eigen::MatrixXd orientation;  ///< G, three columns a field; may be empty
  Eigen::VectorXd orientation_difference;  ///< g0; empty: zero
  double orientation_weight = 0;
  BaseLens base_lens = {};                  ///< that it was made with
  std::vector<BSplineSurface> spread = {};  ///< and with these

  double Cost(const Eigen::VectorXd& parameters) const;
  /// G^T (c - c0) - g0; empty if G is.
  Eigen::VectorXd OrientationError(const Eigen::VectorXd& parameters) const;
};

/// Priors of all cameras, or of none; and of the pattern's points around their
/// nominal places, which costs points_weight / 2 sum |p - p0|^2; and of boards'
/// flex around none, which costs flex_weights / 2 f^2 for each coefficient.
struct GaussianPrior {
  std::vector<CameraPrior> cameras;
  std::vector<Eigen::Vector3d> points_mean;
  double points_weight = 0;
  std::array<double, kNumBendOrders> flex_weights = {};  ///< by BendOrder

  double FlexWeight(BendOrder order) const {
    return flex_weights[static_cast<int>(order)];
  }
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H
