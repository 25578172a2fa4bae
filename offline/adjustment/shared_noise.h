#ifndef RAYGRID_ADJUSTMENT_SHARED_NOISE_H
#define RAYGRID_ADJUSTMENT_SHARED_NOISE_H

#include <Eigen/Core>
#include <random>

#include "adjustment/linear_response.h"

namespace raygrid {

/// The noise of observations, as residuals tell it: a part that each has for
/// itself, and parts that neighbours on the board share, smooth displacements
/// of their own in each view. Standard deviations of a coordinate.
struct ObservationNoise {
  /// Features d apart share exp(-d^2 / 2 length^2) of the variance.
  struct Shared {
    double length = 0;  ///< in spacings of features
    double deviation_px = 0;
  };

  double total_px = 0;  ///< as adjustment found it, which the prior goes by
  double own_px = 0;
  std::vector<Shared> shared;  ///< of other lengths each; may be none

  double SharedPx() const;
  double MeanLength() const;  ///< of the shared parts, by their variances
};

/// A smooth random displacement of points on a plane.
class SmoothField {
 public:
  /// @param length of its covariance, in units of the places
  SmoothField(const Eigen::Matrix2Xd& places, double length);

  /// Displacements of variance 1 in each coordinate, which are independent.
  Eigen::Matrix2Xd Draw(std::mt19937* random_bits) const;

  /// The variance of the sum of displacements times weights.
  double VarianceOf(const Eigen::Matrix2Xd& weights) const;

 private:
  // Sums of independent numbers on the nodes of a lattice, with Gaussian
  // weights: those of a point are products of a few by x and by y.
  static constexpr int kNear = 6;
  using Weights = Eigen::Matrix<double, kNear, Eigen::Dynamic>;
  int columns_ = 0, rows_ = 0;
  Eigen::Matrix2Xi first_;  // the first node of each point
  Weights by_x_, by_y_;
};

/// Fields of all views, over the places of their points on the boards.
std::vector<SmoothField> SmoothFields(
    const LinearResponse& response, const std::vector<Eigen::Vector3d>& points,
    double length);

/// Errors of variance 1: each for itself...
ViewErrors OwnNoise(const LinearResponse& response, std::mt19937* random_bits);
/// ... and shared by neighbours.
ViewErrors SharedNoise(const std::vector<SmoothField>& fields,
                       std::mt19937* random_bits);

/// The noise of a camera's views, as residuals tell it. Its parts are those
/// that leave as large residuals, and as large moves of some pixels by each
/// view: so much is certain of noise that poses take up in part. Its length is
/// the one with which the residuals' products by distance on the board come
/// nearest to what adjustment leaves of such noise; several count as far as
/// they are likely. Adjustment's own share is drawn: each kind of noise is sent
/// through the linear response.
/// @param first,moves of the pixels by the parameters from the first one on, a
///     row each; for example of MovesOfSeenPixels(). Other things that the
///     camera's views tell may stand for pixels.
/// @param noise_px of adjustment
ObservationNoise MeasureNoise(const LinearResponse& response,
                              const AdjustmentState& state, int camera,
                              int first, const Eigen::MatrixXd& moves,
                              double noise_px);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_SHARED_NOISE_H
