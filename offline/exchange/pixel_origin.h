#ifndef RAYGRID_EXCHANGE_PIXEL_ORIGIN_H
#define RAYGRID_EXCHANGE_PIXEL_ORIGIN_H

#include <Eigen/Core>

#include "camera/area.h"

namespace raygrid {

/// Location of pixel (0, 0) in a program's convention.
enum class PixelOrigin {
  /// raygrid, OpenCV, ROS, Kalibr, mrcal, Basalt
  kFirstPixelCenter,
  /// Outer corner of the first pixel: COLMAP, nerfstudio, puzzlepaint.
  kImageCorner,
  /// Image centre: principal points of Metashape.
  kImageCenter
};

/// Returns the origin in raygrid's pixel coordinates.
inline Eigen::Vector2d OriginPx(PixelOrigin origin, const ImageSize& size) {
  if (origin == PixelOrigin::kFirstPixelCenter) return {0, 0};
  if (origin == PixelOrigin::kImageCorner) return {-0.5, -0.5};
  return {size.width / 2.0 - 0.5, size.height / 2.0 - 0.5};
}

/// Converts a pixel from a program's convention to raygrid's, and back. The
/// pixels of every format pass through one of them.
inline Eigen::Vector2d FromProgram(PixelOrigin origin, const ImageSize& size,
                                   const Eigen::Vector2d& pixel) {
  return pixel + OriginPx(origin, size);
}
inline Eigen::Vector2d ToProgram(PixelOrigin origin, const ImageSize& size,
                                 const Eigen::Vector2d& pixel) {
  return pixel - OriginPx(origin, size);
}

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PIXEL_ORIGIN_H
