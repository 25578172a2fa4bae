#ifndef RAYGRID_SIMULATION_SIMULATED_RIG_H
#define RAYGRID_SIMULATION_SIMULATED_RIG_H

#include <cmath>
#include <memory>
#include <vector>

#include "simulation/simulated_observations.h"

namespace raygrid {

/// Cameras with constant relative poses.
struct SimulatedRig {
  std::vector<std::shared_ptr<const CameraModel>> cameras;
  std::vector<Pose> camera_from_rig;
};

/// Makes a row of identical cameras with parallel axes; the first defines the
/// rig frame.
SimulatedRig MakeCameraRow(const std::shared_ptr<const CameraModel>& camera,
                           int count, double baseline_m);

/// A rigid multi-board target: boards side by side in the order of the pattern,
/// each at an angle to the previous one, like a folding screen.
struct FixedBoards {
  double gap_m = 0.1;  ///< between neighbours
  double turn_rad = 15 * M_PI / 180;
  /// The last board is displaced by this distance after half of the frames.
  double move_m = 0;
  /// A board that one camera observes in a frame is hidden from the following
  /// cameras, as if by walls between them.
  bool never_shared = false;
};

struct SimulatedRigObservations {
  std::vector<Dataset> datasets;  ///< by camera
  Pattern true_pattern;
  std::vector<std::vector<BoardPose>> poses;  ///< by camera
};

/// Simulates noisy observations of all of the pattern's boards, each held in
/// front of one camera after the other, independently of the other boards. A
/// camera observes a board from its front if at least eight features are
/// visible, of which at most options.features_per_image are kept; a frame
/// without any has no image of this camera. Reproducible on any machine.
SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const SimulationOptions& options);

/// Like SimulateRig(), for a rigid multi-board target: in each frame, one of
/// its boards is held in front of one of the cameras, roughly upright.
SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const FixedBoards& fixed,
                                     const SimulationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_RIG_H
