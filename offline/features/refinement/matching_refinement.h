#ifndef RAYGRID_FEATURES_REFINEMENT_MATCHING_REFINEMENT_H
#define RAYGRID_FEATURES_REFINEMENT_MATCHING_REFINEMENT_H

#include <cstdint>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"
#include "features/refinement/symmetry_mask.h"

namespace raygrid {

/// Texture of a star that fills its square, repeated periodically: 1 is ink.
class StarTexture {
 public:
  explicit StarTexture(int segments);

  /// u, v: offset in squares from a star's centre
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
  double factor = 0;       ///< f; not positive: colours inverted
  double correlation = 0;  ///< between rendering and image, -1 to 1
};

/// Aligns a rendered star with the image by minimizing
///   C_match(x, f, b) = sum_i (f p_i(x) + b - q_i)^2
/// (paper's supplement, "Feature detection"). p_i: image, q_i: rendering, at
/// one random position in each pixel of the window, with 16-fold supersampling.
/// The initial position is the best one near `start`, or within search_px if no
/// star is found there.
///
/// is_converged is false if the colours are inverted, the centre moves too far,
/// or too little of the window is in the image and the symmetric area.
MatchingResult MatchStar(const GreyImage& image, const StarTexture& texture,
                         const SymmetryMask& mask, const LocalMapping& start,
                         int window_px, double search_px);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_MATCHING_REFINEMENT_H
