#ifndef RAYGRID_CALIBRATION_KNOT_SPACING_SEARCH_H
#define RAYGRID_CALIBRATION_KNOT_SPACING_SEARCH_H

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "evaluation/residual_statistics.h"

namespace raygrid {

/// Returns the z-score of the decrease of the mean Huber loss from `others` to
/// `residuals`: the decrease divided by its standard deviation, which is
/// estimated from the variation between images. Features missing in one of the
/// lists have an error of huber_px there. 0 for fewer than two images.
double ComputeLossZScore(const std::vector<FeatureResidual>& others,
                         const std::vector<FeatureResidual>& residuals,
                         double huber_px = 1);

/// Minimum z-score (ComputeLossZScore()) of a coarser grid over a finer one.
/// Superfluous control points cost little, as the prior constrains them;
/// missing ones cannot be compensated.
constexpr double kMinCoarserZScore = 1;

/// Search over the resolutions of a grid, from coarse to fine.
struct KnotSpacingSearch {
  int chosen = 0;
  std::map<int, std::vector<FeatureResidual>> tried;  ///< held-out, by index

  /// Computes held-out residuals by resolution; fewer after a stop.
  using Measure = std::function<std::vector<std::vector<FeatureResidual>>(
      const std::vector<int>&)>;

  /// Computes held-out residuals of some of the images for a resolution.
  using Probe = std::function<std::vector<FeatureResidual>(int resolution)>;

  /// Searches from a medium resolution to coarser or finer ones while the
  /// held-out loss decreases significantly. If `probe` is given, a resolution
  /// whose loss does not decrease in the probe's images is not measured with
  /// all. Returns nullopt after a stop.
  static std::optional<KnotSpacingSearch> Run(int num_resolutions, int medium,
                                              const Measure& measure,
                                              const Probe& probe = {});
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_KNOT_SPACING_SEARCH_H
