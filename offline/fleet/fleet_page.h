#ifndef RAYGRID_FLEET_FLEET_PAGE_H
#define RAYGRID_FLEET_FLEET_PAGE_H

#include <string>

#include "fleet/fleet_analysis.h"

namespace raygrid {

/// Formats fleet.html: a self-contained file without a script, except for links
/// to the units' own reports. Outliers come first, then changes of means,
/// charts with their limits, lens batches, the gauge study, and all units.
std::string FormatFleetPage(const FleetAnalysis& fleet);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_PAGE_H
