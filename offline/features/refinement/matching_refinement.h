#ifndef RAYGRID_FEATURES_REFINEMENT_MATCHING_REFINEMENT_H
#define RAYGRID_FEATURES_REFINEMENT_MATCHING_REFINEMENT_H

#include <cstdint>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"
#include "features/refinement/symmetry_mask.h"

namespace raygrid {

/// A star filling its square, and by repetition the stars around it, sampled
/// finely: 1 is ink.
class StarTexture {
 public:
  explicit StarTexture(int segments);

  /// Offset in squares from a star's centre.
  int Ink(float u, float v) const {
    const int i = static_cast<int>((u + kShift) * kTexels) & (kTexels - 1);
    const int j = static_cast<int>((v + kShift) * kTexels) & (kTexels - 1);
    return texels_[j * kTexels + i];
  }

 private:
  static constexpr int kTexels = 128;
  static constexpr float kShift = 64.5f;  // keeps the argument positive
  std::vector<uint8_t> texels_;
};

struct MatchingResult {
  bool is_converged = false;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double factor = 0;       ///< f; not positive: rather the inverse of a star
  double correlation = 0;  ///< of rendering and image, -1 to 1
};

/// Moves a star's rendering (16 samples a pixel, one pixel at a random place in
/// each pixel of the window) over the image to where
///   C_match(x, f, b) = sum_i (f p_i(x) + b - q_i)^2
/// is least (paper's supplement, "Feature detection"): p_i the image, q_i the
/// rendering. The first place is the best near start; if there is no star at
/// all, then the best within search_px.
///
/// Not converged: moved by more than search_px, window leaves the image or the
/// symmetric ground so far that little remains.
MatchingResult MatchStar(const GreyImage& image, const StarTexture& texture,
                         const SymmetryMask& mask, const LocalMapping& start,
                         int window_px, double search_px);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_MATCHING_REFINEMENT_H
