#ifndef RAYGRID_INITIALIZATION_GENERIC_START_H
#define RAYGRID_INITIALIZATION_GENERIC_START_H

#include <cstdint>
#include <optional>
#include <vector>

#include "camera/central_generic.h"
#include "dataset/dataset.h"

namespace raygrid {

struct GenericStartOptions {
  /// Cells of the grid along the image's longer side.
  int cells_along = 16;
  int max_triplets = 500;
  uint64_t seed = 0;  ///< of the sample of triplets
  int num_threads = 1;
  /// The area that the camera is to be over; none: that of all features.
  std::optional<Area> area;
};

/// A board in an image, localised with the starting camera.
struct StartingView {
  int image = 0;  ///< index in the dataset
  int board = 0;  ///< index in the pattern
  Pose camera_from_board;
};

struct GenericStart {
  CentralGeneric camera;
  std::vector<StartingView> views;
  /// The median of the reprojection errors of the localised views' features;
  /// features that have no projection count as infinite.
  double median_error_px = 0;
};

/// A first camera from planar boards, for any central lens: nothing is assumed
/// but that neighbouring pixels look along similar directions (Ramalingam and
/// Sturm, as in the paper's supplement, "Calibration initialization"). Nothing
/// if no three views of tilted boards overlap and agree.
std::optional<GenericStart> StartFromThreeViews(
    const Dataset& dataset, const Pattern& pattern,
    const GenericStartOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_GENERIC_START_H
