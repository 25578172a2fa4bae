#ifndef RAYGRID_FLEET_FLEET_INPUT_H
#define RAYGRID_FLEET_FLEET_INPUT_H

#include <string>
#include <vector>

#include "fleet/fleet_statistics.h"
#include "fleet/fleet_table.h"

namespace raygrid {

/// The units that can be compared, and the metrics for comparison.
struct ComparedUnits {
  std::vector<size_t> rows;  ///< rows of the table, in the same order
  FleetInput input;
};

/// Selects the units among the given rows whose camera has the image size of
/// the first; rigs and units without a result are omitted. Units are compared
/// by the pixels of 9 x 7 directions, evenly spaced over the first unit's
/// image; directions that a unit does not observe are omitted. folders: result
/// folder of each row's unit.
ComparedUnits CompareUnits(const std::vector<UnitRow>& rows,
                           const std::vector<std::string>& folders,
                           const std::vector<size_t>& chosen);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_INPUT_H
