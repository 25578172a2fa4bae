#ifndef RAYGRID_FEATURES_REFINEMENT_SYMMETRY_REFINEMENT_H
#define RAYGRID_FEATURES_REFINEMENT_SYMMETRY_REFINEMENT_H

#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"
#include "features/refinement/symmetry_mask.h"

namespace raygrid {

/// Sample offsets in the window in pixels, one of each mirrored pair: several
/// per pixel at random positions, the same for all features (paper, "Feature
/// Extraction": random positions avoid artefacts of bilinear interpolation on a
/// regular grid).
struct SymmetrySamples {
  int window_px = 0, per_pixel = 0;
  std::vector<float> x, y;
};
SymmetrySamples MakeSymmetrySamples(int window_px, int samples_per_pixel);

struct SymmetryOptions {
  Refinement refinement = Refinement::kIntensities;
  /// Point reflection keeps the colours of stars of 4, 8, 12 ... segments, and
  /// inverts the colours of stars of 6, 10, 14 ... segments.
  bool inverts_colors = false;
  /// Optimize the centre only, if the mapping is accurate otherwise.
  bool center_only = false;
  double max_move_px = 2;
  double noise = 0;  ///< standard deviation, grey levels
};

/// Result of refining the window around a feature.
struct WindowFit {
  bool is_converged = false;
  LocalMapping mapping;  ///< refined
  double rms = 0;        ///< RMS residual, grey levels
  double contrast = 0;   ///< standard deviation of the samples, grey levels
  /// Standard deviation of the centre due to image noise, along its less
  /// certain direction; valid for intensities only.
  double stddev_px = 0;
};

/// Minimizes C_sym(H) = sum_i (I(x(s_i)) -+ I(x(-s_i)))^2 over the homography's
/// eight parameters, or over its centre only, by Levenberg-Marquardt (paper,
/// eq. of C_sym). The curvature is fixed.
///
/// is_converged is false if there are too few samples in the image and the
/// symmetric area, or if the centre moves by more than max_move_px.
WindowFit RefineSymmetry(const GreyImage& image, const SymmetrySamples& samples,
                         const SymmetryMask& mask, const LocalMapping& start,
                         const SymmetryOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_SYMMETRY_REFINEMENT_H
