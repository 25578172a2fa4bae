#ifndef RAYGRID_FLEET_FLEET_MEAN_H
#define RAYGRID_FLEET_FLEET_MEAN_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/camera_file.h"
#include "fleet/fleet_analysis.h"

namespace raygrid {

/// Computes the population mean of a fleet as a grid camera: the smooth
/// differences of the inliers, polynomials, are averaged; for the remainder,
/// the median is used, so that poor extrapolation by single units has no
/// effect. At most 200 units are used, evenly spaced. Returns nullopt for a
/// fleet without charts, or with non-central cameras. folders: result folder of
/// each row's unit.
std::optional<CameraFile> ComputeMeanCamera(
    const FleetAnalysis& fleet, const std::vector<std::string>& folders);

/// Computes the mean of any number of central cameras; nullopt if empty.
std::optional<CameraFile> ComputeMeanCamera(
    const std::vector<CameraFile>& cameras);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_MEAN_H
