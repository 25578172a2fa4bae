#ifndef RAYGRID_FLEET_FLEET_INPUT_H
#define RAYGRID_FLEET_FLEET_INPUT_H

#include <string>
#include <vector>

#include "fleet/fleet_statistics.h"
#include "fleet/fleet_table.h"

namespace raygrid {

/// The units that can be compared, and what they are compared by.
struct ComparedUnits {
  std::vector<size_t> rows;  ///< of the table, in its order
  FleetInput input;
};

/// Takes those of the chosen rows' units with a camera of the size that the
/// first one has; rigs and units without a result are left out. They see 9 x 7
/// directions, evenly over the first one's image, as far as all of them do.
/// folders are those of the rows' units.
ComparedUnits CompareUnits(const std::vector<UnitRow>& rows,
                           const std::vector<std::string>& folders,
                           const std::vector<size_t>& chosen);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_INPUT_H
