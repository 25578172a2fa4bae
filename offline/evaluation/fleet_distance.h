#ifndef RAYGRID_EVALUATION_FLEET_DISTANCE_H
#define RAYGRID_EVALUATION_FLEET_DISTANCE_H

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/lens_spread.h"

namespace raygrid {

/// How far a camera lies from a fleet's middle camera, beside how far units of
/// the fleet do.
struct FleetDistance {
  double rms_px = 0;    ///< of the camera; at least, if it looks far beyond
  double units_px = 0;  ///< expected of a unit, with the camera's own errors

  /// Whether so far off no unit of the fleet is to be expected.
  bool IsStranger() const;
  /// "4.1 px from the fleet's middle ..., units of the fleet 0.3 px".
  std::string Text() const;
  /// Text() of a stranger, with what to do.
  std::string Warning() const;
};

/// Root mean squares over some of the camera's pixels, less what the turn does
/// that brings the camera nearest to the middle there. A stated deviation of
/// the camera, in each axis, counts as a difference of units. Nothing where the
/// middle camera's area has none of the pixels.
std::optional<FleetDistance> MeasureFleetDistance(
    const CameraModel& middle, const LensSpread& spread,
    const CameraModel& camera, const DeviationLattice* deviations,
    const std::vector<Eigen::Vector2d>& pixels);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_FLEET_DISTANCE_H
