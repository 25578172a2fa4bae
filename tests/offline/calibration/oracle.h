#ifndef RAYGRID_TESTS_OFFLINE_CALIBRATION_ORACLE_H
#define RAYGRID_TESTS_OFFLINE_CALIBRATION_ORACLE_H

#include "lens_family.h"
#include "simulation/simulated_observations.h"

namespace raygrid {

/// The expected RMS error of rays, in px, of the best estimate from
/// observations of a flat board with white noise, if the covariance of the
/// lens's bumps is known: the posterior standard deviation, linearized at the
/// truth, over a lattice of pixels, after the best rotation. Focal lengths,
/// centre, radial distortion of orders 3, 5 and 7 and tangential distortion are
/// unknown.
double OracleRmsPx(const LensFamily& family, const CameraModel& truth,
                   const SimulatedObservations& simulated, double noise_px);

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_CALIBRATION_ORACLE_H
