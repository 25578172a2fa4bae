#ifndef RAYGRID_CAMERA_IMAGE_CIRCLE_H
#define RAYGRID_CAMERA_IMAGE_CIRCLE_H

#include <Eigen/Core>
#include <cmath>

namespace raygrid {

/// The region of an image that receives light. With a fisheye, the image
/// corners, or everything outside a circle, are dark. In frames of a sensor
/// mode that scales rows and columns differently, the region is an ellipse.
struct ImageCircle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d radii_px = Eigen::Vector2d::Zero();

  bool Contains(const Eigen::Vector2d& pixel) const {
    return (pixel - center).cwiseQuotient(radii_px).squaredNorm() <= 1;
  }
  /// Returns the edge's pixel at an angle from the x axis towards the y axis.
  Eigen::Vector2d At(double angle_rad) const {
    return center + radii_px.cwiseProduct(Eigen::Vector2d(std::cos(angle_rad),
                                                          std::sin(angle_rad)));
  }
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_IMAGE_CIRCLE_H
