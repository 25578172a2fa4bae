#ifndef RAYGRID_FEATURES_REFINEMENT_BLURRED_INK_H
#define RAYGRID_FEATURES_REFINEMENT_BLURRED_INK_H

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace raygrid {

/// Ink from (u0, v0) to (u1, v1): offsets on a board, in squares.
struct InkRectangle {
  double u0, v0, u1, v1;
};

/// Ink as a sum of quadrants that begin at crossings of lines: each has a
/// weight, and covers what has larger u and v.
class Quadrants {
 public:
  /// The ink of rectangles that do not overlap, as far as they reach into the
  /// square from -reach to reach.
  Quadrants(const std::vector<InkRectangle>& ink, double reach);

  const std::vector<double>& u() const { return u_; }
  const std::vector<double>& v() const { return v_; }
  double weight(size_t i, size_t j) const { return weights_(i, j); }

 private:
  std::vector<double> u_, v_;
  Eigen::MatrixXd weights_;
};

/// A Gaussian blur in the image as it is on the board: standard deviations in
/// squares, and the correlation of u and v where squares are seen askew.
struct BoardBlur {
  double sigma_u, sigma_v, correlation;
};

/// Ink after blur, 0 to 1, and its derivatives, also with respect to the
/// logarithm of both standard deviations.
struct BlurredInk {
  double ink = 0, by_u = 0, by_v = 0, by_log_sigma = 0;
};

/// Blurs ink: the bivariate normal distribution of each quadrant, by its
/// tetrachoric series to the fourth power of the correlation; derivatives by
/// one power less.
class InkBlurrer {
 public:
  /// Keeps a reference.
  InkBlurrer(const Quadrants& quadrants, const BoardBlur& blur);

  BlurredInk At(double u, double v);

 private:
  // A half-plane after blur: a normal distribution.
  struct Step {
    double t, density, sum;  // t in standard deviations
  };
  static Step StepAt(double offset, double sigma);

  const Quadrants& quadrants_;
  BoardBlur blur_;
  std::vector<Step> steps_u_, steps_v_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_BLURRED_INK_H
