#ifndef RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H
#define RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H

#include <Eigen/Core>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// The part of a photograph around a feature in which symmetry is sought:
/// intensities, the magnitude of the gradient, or its two components. Enlarged
/// twice by a long filter, so that bilinear interpolation between its values
/// errs four times less than between the photograph's.
class SymmetryPatch {
 public:
  static constexpr int kEnlargement = 2;

  /// Holds all pixels at most reach_px away from pixel (x, y) of center; beyond
  /// the image's edge its last pixels are repeated.
  SymmetryPatch(const GreyImage& image, Refinement refinement,
                const Eigen::Vector2i& center, int reach_px);

  /// Values in a row, and rows.
  int side() const { return side_; }
  /// The position of pixel (x, y) in the channels' rows.
  Eigen::Vector2d FromPixel(const Eigen::Vector2d& pixel) const {
    return kEnlargement * (pixel - origin_.cast<double>());
  }
  const std::vector<std::vector<float>>& channels() const { return channels_; }

  /// The effect of the pattern's point reflection on the channels: it keeps the
  /// values (1) or turns their sign (-1), about an unknown middle if
  /// has_middle.
  struct Reflection {
    float sign;
    bool has_middle;
  };
  /// The reflection of a pattern whose colours it keeps, or inverts.
  Reflection ReflectionOf(bool inverts_colors) const;

 private:
  Refinement refinement_;
  int side_;
  Eigen::Vector2i origin_;  // the pixel of the first value
  std::vector<std::vector<float>> channels_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_SYMMETRY_PATCH_H
