#ifndef RAYGRID_FEATURES_IMAGE_CIRCLE_DETECTION_H
#define RAYGRID_FEATURES_IMAGE_CIRCLE_DETECTION_H

#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/image_circle.h"
#include "dataset/image_files.h"

namespace raygrid {

/// The maximum brightness of square cells over a camera's images, row by row:
/// means of pixels, 0 to 255. Incomplete cells at the image's edge are omitted.
struct BrightestCells {
  int knot_spacing_px = 0, columns = 0, rows = 0;
  std::vector<float> levels;

  /// Returns dark cells, about 320 along the longer side of the image.
  static BrightestCells Over(const ImageSize& size);
  /// Adds an image of this size.
  void Add(const GreyLevels& image);
  void Add(const BrightestCells& other);

  /// Interpolates bilinearly between cell centres.
  double At(const Eigen::Vector2d& pixel) const;
  bool IsInside(const Eigen::Vector2d& pixel) const;
};

/// Detects the image circle by the dark area around it. Returns nullopt unless
/// the images are bright at the centre, dark outside a circle, and the circle
/// has a sharp edge in at least three quarters of its circumference. Images
/// with too little light do not show the circle.
std::optional<ImageCircle> FindImageCircle(const BrightestCells& brightest);

/// Detects the image circle in at most 40 of the images, evenly spaced. Throws
/// InputError.
std::optional<ImageCircle> DetectImageCircle(
    const std::vector<std::string>& image_paths, const ImageSize& size,
    int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_IMAGE_CIRCLE_DETECTION_H
