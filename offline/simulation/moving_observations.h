#ifndef RAYGRID_SIMULATION_MOVING_OBSERVATIONS_H
#define RAYGRID_SIMULATION_MOVING_OBSERVATIONS_H

#include <vector>

#include "simulation/simulated_observations.h"

namespace raygrid {

/// A hand that moves a board, or a camera, while it records.
struct HandMotion {
  double frame_interval_s = 1 / 30.0;
  double row_time_s =
      0;  ///< negative: rows are read from the last to the first
  /// How quickly it moves: 1 takes some three seconds from one side of the
  /// image to the other, and trembles besides by 2 Hz; 0 keeps still.
  double speed = 1;
};

struct MovingObservations {
  SimulatedObservations seen;   ///< poses: when the middle row is read
  std::vector<double> times_s;  ///< of images, when their middle row is read
};

/// Observations of the pattern's first board in consecutive frames, each row at
/// its own time: options.num_images frames at most, without those that show too
/// few features. options.num_shots and bends of views are not looked at.
/// Reproducible on any machine. Throws Error(kTooFew) if no frame shows enough.
MovingObservations SimulateMovingObservations(const CameraModel& camera,
                                              const Pattern& pattern,
                                              const SimulationOptions& options,
                                              const HandMotion& motion);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_MOVING_OBSERVATIONS_H
