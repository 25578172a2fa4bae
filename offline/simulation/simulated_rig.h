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

/// Makes identical cameras on a circle, each turned by the same angle about its
/// vertical axis relative to the previous one; the first defines the rig frame.
SimulatedRig MakeCameraRing(const std::shared_ptr<const CameraModel>& camera,
                            int count, double baseline_m, double turn_rad);

/// A rigid multi-board target: boards side by side in the order of the pattern,
/// each at an angle to the previous one, like a folding screen.
struct FixedBoards {
  double gap_m = 0.1;  ///< between neighbours
  double turn_rad = 15 * M_PI / 180;
  /// The last board is displaced by this distance after half of the frames.
  double move_m = 0;
  /// A board that one camera observes in a frame is hidden from the following
  /// cameras, as if by walls between them.
  bool without_shared_views = false;
};

/// A rig that moves amid boards that are fixed to each other, each upright in
/// front of a camera: board b in front of camera b modulo their number, further
/// ones above. They fill about half of the image.
struct RigMotion {
  /// Maxima of the components of the rotation vector and of the translation,
  /// the latter in units of the distance of the first board.
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Constant(20 * M_PI / 180);
  Eigen::Vector3d translation = Eigen::Vector3d::Constant(0.15);
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

/// Like SimulateRig(), for a rig that moves amid fixed boards.
SimulatedRigObservations SimulateRig(const SimulatedRig& rig,
                                     const Pattern& pattern,
                                     const RigMotion& motion,
                                     const SimulationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_RIG_H
