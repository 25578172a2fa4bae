#ifndef RAYGRID_SIMULATION_FAULTY_OBSERVATIONS_H
#define RAYGRID_SIMULATION_FAULTY_OBSERVATIONS_H

#include "simulation/simulated_observations.h"

namespace raygrid {

/// Systematic errors of calibration images, in addition to noise.
enum class SimulatedFault {
  kNone,
  kImagePosition,   ///< ripples of the lens
  kBoardPosition,   ///< target points differ from nominal
  kDeformation,     ///< per-view deformation of the board
  kInPlane,         ///< per-view in-plane stretch and shear
  kImageAffine,     ///< per-view change of focus and sensor position
  kRollingShutter,  ///< rolling shutter with motion
};
constexpr int kNumFaults = 7;

/// Returns the name of a fault: "none", "lens model", ...
const char* ToString(SimulatedFault fault);

/// Calls SimulateObservations() with a fault that displaces features by a few
/// times strength_px, before poses compensate part of it.
Dataset SimulateFaultyObservations(const CameraModel& camera,
                                   const Pattern& pattern,
                                   const SimulationOptions& options,
                                   SimulatedFault fault,
                                   double strength_px = 0.15);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_FAULTY_OBSERVATIONS_H
