#ifndef RAYGRID_FEATURES_SQUARES_SADDLE_DETECTION_H
#define RAYGRID_FEATURES_SQUARES_SADDLE_DETECTION_H

#include <Eigen/Core>
#include <array>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// A saddle point of the intensities, such as a chessboard's corner.
struct Saddle {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d hessian;
  double strength = 0;  ///< square root of minus the Hessian's determinant

  /// Directions, of unit length, along which the intensity is constant to
  /// second order: a corner's edges. The second is clockwise from the first.
  std::array<Eigen::Vector2d, 2> Edges() const;
  /// Whether it is dark between two edges.
  bool IsDarkBetween(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    return a.dot(hessian * b) < 0;
  }
};

/// Returns the strongest saddles of an image, strongest first; in pixels of the
/// image, of which a version scaled by scale (2, 1, 1/2, 1/4 ...) is searched.
std::vector<Saddle> FindSaddles(const GreyImage& image, double scale,
                                int max_count);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_SADDLE_DETECTION_H
