#ifndef RAYGRID_TOOLS_BATCH_FLEET_H
#define RAYGRID_TOOLS_BATCH_FLEET_H

#include "commands.h"
#include "fleet/fleet_analysis.h"

namespace raygrid {

/// Prints the result of each unit, one line each, or all as JSON; for a plan's
/// complete fleet also its anomalies. Units without a result are listed on
/// standard error.
void PrintUnits(const FleetAnalysis& fleet, const CommonOptions& common);

/// Returns whether a unit has no result that can be inspected.
bool HasNoResult(const UnitRow& row);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_BATCH_FLEET_H
