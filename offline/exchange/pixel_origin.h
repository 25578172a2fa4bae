#ifndef RAYGRID_EXCHANGE_PIXEL_ORIGIN_H
#define RAYGRID_EXCHANGE_PIXEL_ORIGIN_H

#include <Eigen/Core>

#include "camera/area.h"

namespace raygrid {

/// The place of a program's pixel (0, 0).
enum class PixelOrigin {
  /// raygrid, OpenCV, ROS, Kalibr, mrcal, Basalt
  kFirstPixelCenter,
  /// The outer corner of the first pixel: COLMAP, nerfstudio, puzzlepaint.
  kImageCorner,
  /// The middle of the image: principal points of Metashape.
  kImageMiddle
};

/// The origin in raygrid's terms.
inline Eigen::Vector2d OriginPx(PixelOrigin origin, const ImageSize& size) {
  if (origin == PixelOrigin::kFirstPixelCenter) return {0, 0};
  if (origin == PixelOrigin::kImageCorner) return {-0.5, -0.5};
  return {size.width / 2.0 - 0.5, size.height / 2.0 - 0.5};
}

/// A pixel of a program in raygrid's terms, and the other way around. Every
/// format's pixels pass one of these two.
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
