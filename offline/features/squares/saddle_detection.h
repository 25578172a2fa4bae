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

  /// Returns the unit directions along which the second directional derivative
  /// is 0: the edges of a corner. The second one is clockwise from the first.
  std::array<Eigen::Vector2d, 2> Edges() const;
  /// Whether the sector between two edges is dark.
  bool IsDarkBetween(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    return a.dot(hessian * b) < 0;
  }
};

/// Returns the strongest saddles in descending order of strength, in pixels of
/// the image. Searches the image resized by `scale` (2, 1, 1/2, 1/4 ...).
std::vector<Saddle> FindSaddles(const GreyImage& image, double scale,
                                int max_count);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_SADDLE_DETECTION_H
