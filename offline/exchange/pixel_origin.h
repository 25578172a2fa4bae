#ifndef RAYGRID_EXCHANGE_PIXEL_ORIGIN_H
#define RAYGRID_EXCHANGE_PIXEL_ORIGIN_H

#include <Eigen/Core>

namespace raygrid {

/// The place of a program's pixel (0, 0).
enum class PixelOrigin {
  kFirstPixelCenter,  ///< raygrid, OpenCV, ROS, Kalibr, mrcal, Basalt
  kImageCorner  ///< the outer corner of the first pixel: COLMAP, nerfstudio
};

/// A pixel of a program in raygrid's terms, and the other way around. Every
/// format's pixels pass one of these two.
inline Eigen::Vector2d FromProgram(PixelOrigin origin,
                                   const Eigen::Vector2d& pixel) {
  const double shift = origin == PixelOrigin::kImageCorner ? 0.5 : 0;
  return pixel.array() - shift;
}
inline Eigen::Vector2d ToProgram(PixelOrigin origin,
                                 const Eigen::Vector2d& pixel) {
  const double shift = origin == PixelOrigin::kImageCorner ? 0.5 : 0;
  return pixel.array() + shift;
}

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PIXEL_ORIGIN_H
