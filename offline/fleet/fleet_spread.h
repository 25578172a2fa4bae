#ifndef RAYGRID_FLEET_FLEET_SPREAD_H
#define RAYGRID_FLEET_FLEET_SPREAD_H

#include <optional>
#include <vector>

#include "camera/lens_spread.h"
#include "dataset/camera_file.h"

namespace raygrid {

/// Estimates the covariance of the units about their mean: principal directions
/// of their smooth displacements, less the predicted uncertainty in the units'
/// files, plus the uncertainty of the mean. The strongest directions come
/// first, with reproducible signs. Returns nullopt for fewer than 8 units, or
/// for units that do not differ.
std::optional<LensSpread> EstimateSpread(const CameraModel& mean,
                                         const std::vector<CameraFile>& units);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_SPREAD_H
