#ifndef RAYGRID_TOOLS_BATCH_FLEET_H
#define RAYGRID_TOOLS_BATCH_FLEET_H

#include "commands.h"
#include "fleet/fleet_analysis.h"

namespace raygrid {

/// Prints what became of units, one line each, or all of it as JSON; with a
/// plan's whole fleet, what is unusual in it, too. Units without a result go to
/// standard error.
void PrintUnits(const FleetAnalysis& fleet, const CommonOptions& common);

/// Whether there is nothing that could be inspected of a unit.
bool HasNoResult(const UnitRow& row);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_BATCH_FLEET_H
