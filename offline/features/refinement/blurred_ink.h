#ifndef RAYGRID_FEATURES_REFINEMENT_BLURRED_INK_H
#define RAYGRID_FEATURES_REFINEMENT_BLURRED_INK_H

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace raygrid {

/// A rectangle of ink, (u0, v0) to (u1, v1): board offsets in squares.
struct InkRectangle {
  double u0, v0, u1, v1;
};

/// Ink as a weighted sum of quadrants {u >= u_i, v >= v_j} whose corners are
/// intersections of horizontal and vertical lines.
class Quadrants {
 public:
  /// Converts non-overlapping rectangles, clipped to offsets from -reach to
  /// reach.
  Quadrants(const std::vector<InkRectangle>& ink, double reach);

  const std::vector<double>& u() const { return u_; }
  const std::vector<double>& v() const { return v_; }
  double weight(size_t i, size_t j) const { return weights_(i, j); }

 private:
  std::vector<double> u_, v_;
  Eigen::MatrixXd weights_;
};

/// Gaussian blur of the image in board coordinates: standard deviations in
/// squares, and the correlation of u and v due to oblique views.
struct BoardBlur {
  double sigma_u, sigma_v, correlation;
};

/// Blurred ink from 0 to 1, and its derivatives with respect to u, v and the
/// logarithm of both standard deviations.
struct BlurredInk {
  double ink = 0, J_u = 0, J_v = 0, J_log_sigma = 0;
};

/// Blurs ink with the bivariate normal distribution of each quadrant,
/// approximated by the tetrachoric series: up to the fourth power of the
/// correlation for values, the third for derivatives.
class InkBlurrer {
 public:
  /// Keeps a reference to the quadrants.
  InkBlurrer(const Quadrants& quadrants, const BoardBlur& blur);

  BlurredInk At(double u, double v);

 private:
  // A blurred step function: density and cumulative distribution at t.
  struct Step {
    double t, density, sum;  // t in standard deviations
  };
  static Step EvaluateBlurredStep(double offset, double sigma);

  const Quadrants& quadrants_;
  BoardBlur blur_;
  std::vector<Step> steps_u_, steps_v_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_BLURRED_INK_H
