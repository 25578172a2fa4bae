#ifndef RAYGRID_SIMULATION_SIMULATED_RIG_H
#define RAYGRID_SIMULATION_SIMULATED_RIG_H

#include <cmath>
#include <memory>
#include <vector>

#include "simulation/simulated_observations.h"

namespace raygrid {

/// Known cameras that do not move against each other.
struct SimulatedRig {
  std::vector<std::shared_ptr<const CameraModel>> cameras;
  std::vector<Pose> camera_from_rig;
};

/// Cameras of one kind in a row, looking the same way; the first is the rig's
/// frame.
SimulatedRig CamerasInARow(const std::shared_ptr<const CameraModel>& camera,
                           int count, double baseline_m);

/// Boards that are fixed to each other: side by side in the order of the
/// pattern, each turned against the one before it like leaves of a screen.
struct FixedBoards {
  double gap_m = 0.1;  ///< between neighbours
  double turn_rad = 15 * M_PI / 180;
  /// The last board is moved by so much, any way, after half of the instants.
  double move_m = 0;
  /// No camera sees a board that one before it sees at the instant, as if walls
  /// stood between them.
  bool never_shared = false;
};

struct SimulatedRigObservations {
  std::vector<Dataset> datasets;  ///< by camera
  Pattern true_pattern;
  std::vector<std::vector<BoardPose>> poses;  ///< by camera
};

/// Noisy observations of all of the pattern's boards, each held in front of one
/// camera after the other, and at each instant independently of the other
/// boards. A camera sees a board if it sees its front and at least eight of its
/// features, of which options.features_per_image remain at most; it has no
/// image of an instant at which it sees none. Reproducible on any machine.
SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const SimulationOptions& options);

/// Boards that are fixed to each other instead: each instant, one of their
/// places is held in front of one of the cameras, roughly upright.
SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const FixedBoards& fixed,
                                     const SimulationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_RIG_H
