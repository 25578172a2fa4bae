#ifndef RAYGRID_FLEET_FLEET_SPREAD_H
#define RAYGRID_FLEET_FLEET_SPREAD_H

#include <optional>
#include <vector>

#include "camera/lens_spread.h"
#include "dataset/camera_file.h"

namespace raygrid {

/// How a further unit is expected to differ from the middle of units: by the
/// covariance of their smooth displacements, less the errors that the units'
/// files state, and with what is not known of the middle. The strongest
/// directions come first, with signs that are the same whatever finds them.
/// Nothing of fewer than 8 units, or of units that do not differ.
std::optional<LensSpread> SpreadAround(const CameraModel& middle,
                                       const std::vector<CameraFile>& units);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_SPREAD_H
