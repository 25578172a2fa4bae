#ifndef RAYGRID_CAMERA_AREA_H
#define RAYGRID_CAMERA_AREA_H

#include <Eigen/Core>
#include <algorithm>

namespace raygrid {

struct ImageSize {
  int width = 0;
  int height = 0;
  bool operator==(const ImageSize& other) const {
    return width == other.width && height == other.height;
  }
  bool operator!=(const ImageSize& other) const { return !(*this == other); }
};

/// Axis-aligned rectangle in pixels, inclusive; (0, 0) is the centre of the
/// top-left pixel.
struct Area {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  double width() const { return x1 - x0; }
  double height() const { return y1 - y0; }
  Eigen::Vector2d center() const { return {(x0 + x1) / 2, (y0 + y1) / 2}; }

  bool Contains(const Eigen::Vector2d& pixel, double margin_px = 0) const {
    return pixel.x() >= x0 - margin_px && pixel.x() <= x1 + margin_px &&
           pixel.y() >= y0 - margin_px && pixel.y() <= y1 + margin_px;
  }
  void Extend(const Eigen::Vector2d& pixel) {
    x0 = std::min(x0, pixel.x());
    y0 = std::min(y0, pixel.y());
    x1 = std::max(x1, pixel.x());
    y1 = std::max(y1, pixel.y());
  }
  bool operator==(const Area& other) const {
    return x0 == other.x0 && y0 == other.y0 && x1 == other.x1 && y1 == other.y1;
  }
};

/// Choice of the calibrated area: the whole image, or the bounding rectangle of
/// the observed features.
enum class AreaChoice { kWholeImage, kFeatures };

/// Returns the whole image, from the first pixel's centre to the last pixel's.
inline Area WholeImage(const ImageSize& size) {
  return {0, 0, size.width - 1.0, size.height - 1.0};
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_AREA_H
