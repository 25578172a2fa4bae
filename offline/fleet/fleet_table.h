#ifndef RAYGRID_FLEET_FLEET_TABLE_H
#define RAYGRID_FLEET_FLEET_TABLE_H

#include <map>
#include <string>
#include <vector>

#include "fleet/batch_plan.h"

namespace raygrid {

/// How a unit came out.
struct UnitRow {
  std::string serial;
  /// "pass", "warn" or "fail" as its verdict and limits are; "error" if it has
  /// no result; "missing" if it was not tried.
  std::string status = "missing";
  std::string reason;
  int exit_code = 0;                      ///< of an error
  std::map<std::string, double> figures;  ///< those of FigureNames() known
  double seconds = 0;                     ///< of its calibration; 0: not known
  /// Names of charts whose limits it leaves (FindOutliers()).
  std::vector<std::string> unusual;
  /// From the plan, or "" (BatchUnit).
  std::string lens_batch, repeats, person, station;
};

/// The row of a unit from the files of its result. A figure beyond its limits,
/// or one that is not known, makes it "fail". Throws InputError.
///
/// The focal length and centre are those of the image about the camera's z
/// axis: pixels per radian, and the pixel that looks along it. The worst
/// deviation is the largest stated one of the calibrated area, over a range at
/// any of its values. Rigs have only
/// what result.json says of them.
UnitRow ReadUnitRow(const std::string& serial, const std::string& folder,
                    const FigureLimits& limits);

/// fleet.csv; fields that are not known are empty.
std::string FormatFleetTable(const std::vector<UnitRow>& rows);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_TABLE_H
