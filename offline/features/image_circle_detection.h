#ifndef RAYGRID_FEATURES_IMAGE_CIRCLE_DETECTION_H
#define RAYGRID_FEATURES_IMAGE_CIRCLE_DETECTION_H

#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/image_circle.h"
#include "dataset/image_files.h"

namespace raygrid {

/// The brightest that square cells of a camera's images were, row by row: the
/// means of their pixels, 0 to 255. Cells cut off by the image's edge are left
/// out.
struct BrightestCells {
  int knot_spacing_px = 0, columns = 0, rows = 0;
  std::vector<float> levels;

  /// Dark cells, about 320 along the image's longer side.
  static BrightestCells Over(const ImageSize& size);
  /// An image of this size.
  void Add(const GreyLevels& image);
  void Add(const BrightestCells& other);

  /// Bilinear between the cells' middles.
  double At(const Eigen::Vector2d& pixel) const;
  bool IsInside(const Eigen::Vector2d& pixel) const;
};

/// The image circle that images leave dark around it. Nothing unless they are
/// bright in the middle, dark beyond a circle whose edge is sharp and is seen
/// in three quarters of its round at least. Images that light too little of it
/// do not show it.
std::optional<ImageCircle> FindImageCircle(const BrightestCells& brightest);

/// The image circle of the images, at most 40 of which are read, evenly chosen.
/// Throws InputError.
std::optional<ImageCircle> DetectImageCircle(
    const std::vector<std::string>& image_paths, const ImageSize& size,
    int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_IMAGE_CIRCLE_DETECTION_H
