#ifndef RAYGRID_FEATURES_REFINEMENT_WINDOW_MAPPING_H
#define RAYGRID_FEATURES_REFINEMENT_WINDOW_MAPPING_H

#include <optional>

#include "features/board_view/feature_lattice.h"
#include "features/board_view/lattice_camera.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// The local mapping within a feature's window.
struct WindowMapping {
  LocalMapping mapping;
  int degree = 0;  ///< degree of the polynomial; 0: no mapping
  /// Standard deviation of the centre in symmetry refinement, in pixels, due to
  /// lens curvature that the mapping does not compensate.
  double sagitta_stddev_px = 0;
};

/// Local mappings within the windows of features: fitted to the neighbours of
/// each feature, or, for strong lens curvature, computed from the lens model
/// fitted to the whole lattice.
class WindowMappings {
 public:
  /// Keeps references to the board and the lattice.
  WindowMappings(const Board& board, const FeatureLattice& lattice,
                 const ImageSize& size, double window_px)
      : board_(board), lattice_(lattice), size_(size), window_px_(window_px) {}

  WindowMapping At(int column, int row);

 private:
  const std::optional<LatticeCamera>& Lens();
  std::optional<WindowMapping> PredictWithCamera(int column, int row);

  const Board& board_;
  const FeatureLattice& lattice_;
  ImageSize size_;
  double window_px_;
  bool is_camera_fitted_ = false;
  std::optional<LatticeCamera> lens_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_WINDOW_MAPPING_H
