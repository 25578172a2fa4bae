#ifndef RAYGRID_FLEET_FLEET_PAGE_H
#define RAYGRID_FLEET_FLEET_PAGE_H

#include <string>

#include "fleet/fleet_analysis.h"

namespace raygrid {

/// fleet.html: one file without references to others but to the units' own
/// reports, and without a script. What is unusual comes first, then changes of
/// means, charts with their limits, batches of lenses, the gauge, and all
/// units.
std::string FormatFleetPage(const FleetAnalysis& fleet);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_PAGE_H
