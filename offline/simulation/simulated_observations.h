#ifndef RAYGRID_SIMULATION_SIMULATED_OBSERVATIONS_H
#define RAYGRID_SIMULATION_SIMULATED_OBSERVATIONS_H

#include <cstdint>
#include <vector>

#include "camera/camera_model.h"
#include "dataset/dataset.h"

namespace raygrid {

struct SimulationOptions {
  int num_images = 100;
  int features_per_image = 240;  ///< at most; images with fewer are not made
  double noise_px = 0.05;        ///< standard deviation of each coordinate
  /// The board is bent by this much at its edges: a paraboloid.
  double board_bend_m = 0;
  uint64_t seed = 1;
};

struct SimulatedObservations {
  Dataset dataset;
  Pattern true_pattern;  ///< with the points where they really are
  std::vector<BoardPose> poses;
};

/// Exact or noisy observations of the pattern's first board, held all over the
/// field of view, partly beyond its edge, at distances from which it is
/// half as wide as the image to nearly twice as wide, tilted by up to 60
/// degrees. Reproducible on any machine.
SimulatedObservations SimulateObservations(const CameraModel& camera,
                                           const Pattern& pattern,
                                           const SimulationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_OBSERVATIONS_H
