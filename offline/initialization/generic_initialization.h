#ifndef RAYGRID_INITIALIZATION_GENERIC_INITIALIZATION_H
#define RAYGRID_INITIALIZATION_GENERIC_INITIALIZATION_H

#include <cstdint>
#include <optional>
#include <vector>

#include "camera/central_generic.h"
#include "dataset/dataset.h"

namespace raygrid {

struct GenericInitializationOptions {
  /// Number of grid cells along the longer side of the image.
  int cells_along = 16;
  int max_triplets = 500;
  uint64_t seed = 0;  ///< seed for sampling triplets
  int num_threads = 1;
  /// Calibrated area; nullopt: the extent of all features.
  std::optional<Area> area;
};

/// A board in an image, with its pose in the initial camera.
struct InitialView {
  int image = 0;  ///< index in the dataset
  int board = 0;  ///< index in the pattern
  Pose camera_from_board;
};

struct GenericInitialization {
  CentralGeneric camera;
  std::vector<InitialView> views;
  /// Median reprojection error of the localized views' features; infinite for
  /// features without a projection.
  double median_error_px = 0;
};

/// Initializes a central generic camera from planar boards, assuming only that
/// neighbouring pixels have similar directions (Ramalingam and Sturm, as in the
/// paper's supplement, "Calibration initialization"). Returns nullopt if no
/// three overlapping views of tilted boards are consistent.
std::optional<GenericInitialization> InitializeFromThreeViews(
    const Dataset& dataset, const Pattern& pattern,
    const GenericInitializationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_GENERIC_INITIALIZATION_H
