#ifndef RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H
#define RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
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
  double tilt_firmness = 0;                 ///< that it was made with
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

/// Smoothness of a grid's difference from base: K sums the squared second
/// differences, across, down and mixed, of the displacement in pixels that
/// separates the two. Keeps nodes that few observations determine near where
/// their neighbours and the parametric lens would have them. Focal lengths and
/// centre are free, and radial distortion of orders 3, 5 and 7 nearly so: those
/// of the parametric lens make up for what it does not follow, and beyond the
/// outermost features they are no better known than the features tell. Also
/// holds the camera's orientation, which no observation can see,
/// to base's.
///
/// The terms that tilt a lens are free as well if the base's were fitted to the
/// observations: held as firmly as they were in that fit, by the cost of a term
/// that moves the farthest corner by a pixel (camera/decentring.h), as a part
/// of the residuals' variance. Taken for known, with 0, they would lend their
/// errors to the grid.
///
/// spread tells how lenses differ from base, if that is a fleet's middle: by
/// displacements in pixels, each times a standard normal number. Then the
/// smoothness is about what these and the lens leave, of which no part is to be
/// a turn.
CameraPrior SmoothnessPrior(const CentralGeneric& base,
                            double tilt_firmness = 0,
                            const std::vector<BSplineSurface>& spread = {});

/// The smoothness priors of a stack's terms, each as that of a grid and a group
/// of its own: the first around base, those by which the camera changes with
/// the conditions around none. What the data do not tell of a term's change
/// stays none. The camera does not turn with a condition: observations cannot
/// tell, since each has its pose.
CameraPrior StackPrior(const CentralGeneric& base, int num_terms);

/// The smoothness prior of the directions of a grid of lines, and, as a group
/// of its own, of the lines' points around the origin: three smooth fields, in
/// the pixels that their displacement across the line moves a point's image at
/// distance_m.
///
/// Observations do not see a shift of all points together, which the poses
/// undo: the points end where they are smallest and smoothest. Nor do they see
/// points drift along the lines, o(x) -> o(x) + f(x) d(x): the prior holds each
/// control point's point in the plane across base's direction.
CameraPrior NonCentralPrior(const CentralGeneric& base, double distance_m,
                            double tilt_firmness = 0);

/// Distortion coefficients around zero, each in the pixels that it moves the
/// corner of an area by: high orders that the observations say little about
/// stay small, where they would otherwise fold the image beyond the outermost
/// features. Focal lengths and centre are free. A radial spline scatters
/// smoothly around where it is, as a group of its own. So do the terms that
/// tilt the lens, whose weight is at least what camera/decentring.h asks for
/// with so many features.
CameraPrior DistortionPrior(const ParametricModel& lens, const Area& area,
                            int num_features);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_GAUSSIAN_PRIOR_H
