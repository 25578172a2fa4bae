#ifndef RAYGRID_FEATURES_SQUARES_SADDLE_DETECTION_H
#define RAYGRID_FEATURES_SQUARES_SADDLE_DETECTION_H

#include <Eigen/Core>
#include <array>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// A saddle point of the intensities, as the corner of four squares is one.
struct Saddle {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d hessian;
  double strength = 0;  ///< square root of minus the Hessian's determinant

  /// The directions, of unit length, in which the intensity neither rises nor
  /// falls: a corner's edges. The second is clockwise from the first.
  std::array<Eigen::Vector2d, 2> Edges() const;
  /// Whether it is dark between two edges.
  bool IsDarkBetween(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    return a.dot(hessian * b) < 0;
  }
};

/// The strongest saddles of an image, strongest first; in pixels of the whole
/// image, of which scale (2, 1, 1/2, 1/4 ...) is the size that is searched.
std::vector<Saddle> FindSaddles(const GreyImage& image, double scale,
                                int max_count);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_SADDLE_DETECTION_H
