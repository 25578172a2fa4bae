#ifndef RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H
#define RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H

#include <Eigen/Core>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// The image patch around a feature used for symmetry: intensities, gradient
/// magnitudes, or both gradient components. Upsampled twice by a long filter,
/// so that the error of bilinear interpolation is a quarter of that in the
/// original image.
class SymmetryPatch {
 public:
  static constexpr int kEnlargement = 2;

  /// Contains all pixels within reach_px of pixel (x, y) of center; the image's
  /// edge pixels are repeated beyond it.
  SymmetryPatch(const GreyImage& image, Refinement refinement,
                const Eigen::Vector2i& center, int reach_px);

  /// Number of rows, and of values per row.
  int side() const { return side_; }
  /// Converts pixel (x, y) to a position in the channels.
  Eigen::Vector2d FromPixel(const Eigen::Vector2d& pixel) const {
    return kEnlargement * (pixel - origin_.cast<double>());
  }
  const std::vector<std::vector<float>>& channels() const { return channels_; }

  /// Effect of the pattern's point reflection on the channels: it keeps values
  /// (1) or negates them (-1), relative to an unknown mean if has_middle.
  struct Reflection {
    float sign;
    bool has_middle;
  };
  /// Returns the reflection for a pattern whose colours it keeps or inverts.
  Reflection ComputeReflection(bool inverts_colors) const;

 private:
  Refinement refinement_;
  int side_;
  Eigen::Vector2i origin_;  // pixel of the first value
  std::vector<std::vector<float>> channels_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H
