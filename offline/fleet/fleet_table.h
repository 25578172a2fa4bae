#ifndef RAYGRID_FLEET_FLEET_TABLE_H
#define RAYGRID_FLEET_FLEET_TABLE_H

#include <map>
#include <string>
#include <vector>

#include "fleet/batch_plan.h"

namespace raygrid {

/// The result of a unit.
struct UnitRow {
  std::string serial;
  /// "pass", "warn" or "fail" by its status and limits; "error" if it has no
  /// result; "missing" if it was not calibrated.
  std::string status = "missing";
  std::string reason;
  int exit_code = 0;                      ///< exit code of an error
  std::map<std::string, double> metrics;  ///< by name, if known
  double seconds = 0;                     ///< calibration time; 0: unknown
  /// Names of the charts whose limits it exceeds (FindOutliers()).
  std::vector<std::string> outliers;
  /// Values from the plan (BatchUnit), or "".
  std::string lens_batch, repeats, person, station;
};

/// Reads the row of a unit from its result files. The status is "fail" if a
/// metric exceeds its limits or is unknown. Throws InputError.
///
/// Focal length and principal point are evaluated at the camera's z axis:
/// pixels per radian, and the pixel that observes it. The maximum standard
/// deviation is over the calibrated area, and over the range of an
/// operating-point model. For rigs, only result.json is used.
UnitRow ReadUnitRow(const std::string& serial, const std::string& folder,
                    const MetricLimits& limits);

/// Formats fleet.csv; unknown fields are empty.
std::string FormatFleetTable(const std::vector<UnitRow>& rows);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_TABLE_H
