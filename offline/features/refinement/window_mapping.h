#ifndef RAYGRID_FEATURES_REFINEMENT_WINDOW_MAPPING_H
#define RAYGRID_FEATURES_REFINEMENT_WINDOW_MAPPING_H

#include <optional>

#include "features/board_view/feature_lattice.h"
#include "features/board_view/lattice_lens.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// How the board appears within a feature's window.
struct WindowMapping {
  LocalMapping mapping;
  int degree = 0;  ///< of its polynomial; 0 if it is not known
  /// The lens's bend that symmetry takes, or would take, for a shift of the
  /// centre: the standard deviation of the part that the mapping does not know,
  /// in pixels.
  double bend_deviation_px = 0;
};

/// The windows of one lattice's features. What a feature's neighbours say of
/// the window is enough for most; where the lens bends it much, the lens that
/// explains the whole lattice says more.
class WindowMappings {
 public:
  /// Keeps references.
  WindowMappings(const Board& board, const FeatureLattice& lattice,
                 const ImageSize& size, double window_px)
      : board_(board), lattice_(lattice), size_(size), window_px_(window_px) {}

  WindowMapping At(int column, int row);

 private:
  const std::optional<LatticeLens>& Lens();
  std::optional<WindowMapping> ByLens(int column, int row);

  const Board& board_;
  const FeatureLattice& lattice_;
  ImageSize size_;
  double window_px_;
  bool is_lens_made_ = false;
  std::optional<LatticeLens> lens_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_WINDOW_MAPPING_H
