#ifndef RAYGRID_SIMULATION_FAULTY_OBSERVATIONS_H
#define RAYGRID_SIMULATION_FAULTY_OBSERVATIONS_H

#include "simulation/simulated_observations.h"

namespace raygrid {

/// Faults that the images of a calibration may have, besides noise.
enum class SimulatedFault {
  kNone,
  kImagePlace,   ///< ripples of the lens
  kBoardPlace,   ///< points of the board are not where they should be
  kBend,         ///< the board bends, differently in each view
  kInPlane,      ///< it is stretched and sheared, differently in each view
  kImageAffine,  ///< focus and the sensor's place change from view to view
  kRowTime,      ///< rows are taken one after the other, in motion
};
constexpr int kNumFaults = 7;

/// "none", "lens model", ...
const char* NameOf(SimulatedFault fault);

/// The observations of SimulateObservations() with a fault that moves features
/// by a few times strength_px, before poses make up for some of it.
Dataset SimulateFaultyObservations(const CameraModel& camera,
                                   const Pattern& pattern,
                                   const SimulationOptions& options,
                                   SimulatedFault fault,
                                   double strength_px = 0.15);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_FAULTY_OBSERVATIONS_H
