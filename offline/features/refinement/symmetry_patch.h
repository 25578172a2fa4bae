#ifndef RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H
#define RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H

#include <Eigen/Core>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// The image patch around a feature for symmetry refinement: intensities,
/// gradient magnitudes, or both gradient components. Upsampled by a factor of 2
/// with a Lanczos filter, which reduces the error of bilinear interpolation to
/// a quarter.
class SymmetryPatch {
 public:
  static constexpr int kEnlargement = 2;

  /// Contains all pixels within reach_px of the centre pixel; edge pixels are
  /// replicated outside the image.
  SymmetryPatch(const GreyImage& image, Refinement refinement,
                const Eigen::Vector2i& center, int reach_px);

  /// Returns the number of rows, and of values per row.
  int side() const { return side_; }
  /// Converts pixel (x, y) to a position in the channels.
  Eigen::Vector2d FromPixel(const Eigen::Vector2d& pixel) const {
    return kEnlargement * (pixel - origin_.cast<double>());
  }
  const std::vector<std::vector<float>>& channels() const { return channels_; }

  /// Effect of the pattern's point reflection on the channels: values are kept
  /// (sign 1) or negated (-1), relative to an unknown mean if has_middle.
  struct Reflection {
    float sign;
    bool has_middle;
  };
  /// Returns the reflection for patterns whose colours are kept or inverted by
  /// point reflection.
  Reflection ComputeReflection(bool inverts_colors) const;

 private:
  Refinement refinement_;
  int side_;
  Eigen::Vector2i origin_;  // pixel of the first value
  std::vector<std::vector<float>> channels_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H
