#ifndef RAYGRID_FLEET_FLEET_MEAN_H
#define RAYGRID_FLEET_FLEET_MEAN_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/camera_file.h"
#include "fleet/fleet_analysis.h"

namespace raygrid {

/// The middle camera of a fleet, as a grid: each pixel's direction is the
/// median over the usual units that see it, in both coordinates of the chart,
/// so a unit that goes astray where it saw nothing counts for nothing. At most
/// 200 units are taken, evenly. Nothing of a fleet without charts, or of lenses
/// whose lines do not meet. folders are those of the rows' units.
std::optional<CameraFile> MeanCamera(const FleetAnalysis& fleet,
                                     const std::vector<std::string>& folders);

/// The middle of central cameras, whatever their number; nothing of none.
std::optional<CameraFile> MeanCamera(const std::vector<CameraFile>& cameras);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_MEAN_H
