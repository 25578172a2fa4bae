#ifndef RAYGRID_FEATURES_REFINEMENT_SYMMETRY_REFINEMENT_H
#define RAYGRID_FEATURES_REFINEMENT_SYMMETRY_REFINEMENT_H

#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"
#include "features/refinement/symmetry_mask.h"

namespace raygrid {

/// Offsets in the window, in pixels, of one of each mirrored pair: several
/// random ones in every pixel, the same for all features (paper, "Feature
/// Extraction": randomness spares us the artefacts of bilinear interpolation on
/// a lattice).
struct SymmetrySamples {
  int window_px = 0, per_pixel = 0;
  std::vector<float> x, y;
};
SymmetrySamples MakeSymmetrySamples(int window_px, int samples_per_pixel);

struct SymmetryOptions {
  Refinement refinement = Refinement::kIntensities;
  /// Point reflection keeps the colours of stars of 4, 8, 12 ... segments, and
  /// inverts those of 6, 10, 14 ...
  bool inverts_colors = false;
  /// The centre alone, where the rest of the mapping is known well.
  bool center_only = false;
  double max_move_px = 2;
  double noise = 0;  ///< of the image, grey levels
};

/// The result of refining the window around a feature.
struct WindowFit {
  bool is_converged = false;
  LocalMapping mapping;  ///< refined
  double rms = 0;        ///< of the differences, grey levels
  double contrast = 0;   ///< RMS deviation from the mean, grey levels
  /// Standard deviation of the centre by the image's noise, along its less
  /// certain direction; of intensities.
  double deviation_px = 0;
};

/// Minimises C_sym(H) = sum_i (I(x(s_i)) -+ I(x(-s_i)))^2 over the homography's
/// eight parameters by Levenberg and Marquardt's method (paper, eq. of
/// C_sym), with the curvature fixed; or over its centre alone.
///
/// Not converged: too few samples in the image and on symmetric ground, or
/// moved by more than max_move_px.
WindowFit RefineSymmetry(const GreyImage& image, const SymmetrySamples& samples,
                         const SymmetryMask& mask, const LocalMapping& start,
                         const SymmetryOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_SYMMETRY_REFINEMENT_H
