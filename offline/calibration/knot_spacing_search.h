#ifndef RAYGRID_CALIBRATION_KNOT_SPACING_SEARCH_H
#define RAYGRID_CALIBRATION_KNOT_SPACING_SEARCH_H

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "evaluation/residual_statistics.h"

namespace raygrid {

/// By how much the mean Huber loss of residuals is below that of others, of the
/// same features: in standard deviations of that difference, as images differ
/// in it. A feature that only one of both has is huber_px off in the other. 0
/// for fewer than two images.
double ComputeLossGain(const std::vector<FeatureResidual>& others,
                       const std::vector<FeatureResidual>& residuals,
                       double huber_px = 1);

/// A prior holds what a grid has too many of, at little loss; what it has too
/// few of is lost. So a coarser one has to gain something: ComputeLossGain()
/// the finer one.
constexpr double kCoarserGain = 1;

/// Which of a list of resolutions of a grid, from coarse to fine, to take.
struct KnotSpacingSearch {
  int chosen = 0;
  std::map<int, std::vector<FeatureResidual>> tried;  ///< held-out, by index

  /// Held-out residuals with some resolutions; fewer after a stop.
  using Measure = std::function<std::vector<std::vector<FeatureResidual>>(
      const std::vector<int>&)>;

  /// Held-out residuals of some of the images with a resolution.
  using Probe = std::function<std::vector<FeatureResidual>(int resolution)>;

  /// Goes from a medium resolution to coarser or to finer ones as long as the
  /// held-out loss surely falls. One whose loss does not fall in the images
  /// that probe is given, if it is, is not measured with all. Nothing after a
  /// stop.
  static std::optional<KnotSpacingSearch> Run(int num_resolutions, int medium,
                                              const Measure& measure,
                                              const Probe& probe = {});
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_KNOT_SPACING_SEARCH_H
