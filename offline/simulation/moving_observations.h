#ifndef RAYGRID_SIMULATION_MOVING_OBSERVATIONS_H
#define RAYGRID_SIMULATION_MOVING_OBSERVATIONS_H

#include <vector>

#include "simulation/simulated_observations.h"

namespace raygrid {

/// The hand-held motion of a board, or a camera, during a recording.
struct HandMotion {
  double frame_interval_s = 1 / 30.0;
  double line_delay_s = 0;  ///< negative: from the last row to the first
  /// Speed of motion: 1 takes about three seconds from one side of the image to
  /// the other, with a tremor of 2 Hz; 0 is static.
  double speed = 1;
};

struct MovingObservations {
  SimulatedObservations seen;   ///< poses at the central row
  std::vector<double> times_s;  ///< image times, at the central row
};

/// Simulates the pattern's first board in consecutive frames with a rolling
/// shutter: at most options.num_images frames, without those that show too few
/// features. options.num_shots and per-view deformation are ignored.
/// Reproducible on any machine. Throws Error(kInsufficientData) if no frame
/// shows enough.
MovingObservations SimulateMovingObservations(const CameraModel& camera,
                                              const Pattern& pattern,
                                              const SimulationOptions& options,
                                              const HandMotion& motion);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_MOVING_OBSERVATIONS_H
