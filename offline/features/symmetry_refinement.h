#ifndef RAYGRID_FEATURES_SYMMETRY_REFINEMENT_H
#define RAYGRID_FEATURES_SYMMETRY_REFINEMENT_H

#include <vector>

#include "features/detection.h"
#include "features/local_mapping.h"
#include "features/symmetry_mask.h"

namespace raygrid {

/// The images in which symmetry is sought: intensities, the magnitude of the
/// gradient, or its two components. All enlarged twice by a long filter, so
/// that bilinear interpolation between their values errs four times less than
/// between the photograph's: value (2x, 2y) lies at pixel (x, y).
struct SymmetryImage {
  static constexpr int kEnlargement = 2;

  ImageSize size;  ///< enlarged
  std::vector<std::vector<float>> channels;
  /// What point reflection of the pattern does to the channels, and what it
  /// does where it inverts the colours: it keeps the values (1) or turns their
  /// sign (-1), about an unknown middle if has_middle.
  float reflection = 1, inverted_reflection = -1;
  bool has_middle = true;
};

SymmetryImage MakeSymmetryImage(const GreyImage& image, Refinement refinement);

/// Offsets in the window, in pixels, of one of each mirrored pair: several
/// random ones in every pixel, the same for all features (paper, "Feature
/// Extraction": randomness spares us the artefacts of bilinear interpolation on
/// a lattice).
struct SymmetrySamples {
  std::vector<float> x, y;
};
SymmetrySamples MakeSymmetrySamples(int window_px, int samples_per_pixel);

struct SymmetryResult {
  bool is_converged = false;
  LocalMapping mapping;  ///< refined
  double rms = 0;        ///< of the differences, grey levels
  double contrast = 0;   ///< RMS deviation from the mean, grey levels
};

/// Minimises C_sym(H) = sum_i (I(x(s_i)) -+ I(x(-s_i)))^2 over the homography's
/// eight parameters by Levenberg and Marquardt's method (paper, eq. of
/// C_sym), with the curvature fixed; or over its centre alone, where the rest
/// is known better from the neighbours. Point reflection keeps the colours of
/// stars of 4, 8, 12 ... segments, and inverts those of 6, 10, 14 ...:
/// inverts_colors.
///
/// Not converged: too few samples in the image and on symmetric ground, or
/// moved by more than max_move_px.
SymmetryResult RefineSymmetry(const SymmetryImage& image,
                              const SymmetrySamples& samples,
                              const SymmetryMask& mask,
                              const LocalMapping& start, bool inverts_colors,
                              bool center_only, double max_move_px);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SYMMETRY_REFINEMENT_H
