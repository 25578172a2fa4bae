/// --at: the operating point at which a camera is evaluated.
#ifndef RAYGRID_TOOLS_REQUESTED_OPERATING_POINT_H
#define RAYGRID_TOOLS_REQUESTED_OPERATING_POINT_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "camera/operating_point_model.h"

namespace raygrid {

/// A value of the only variable, or values by variable name; empty if not
/// specified.
struct RequestedOperatingPoint {
  std::optional<double> alone;
  std::map<OperatingParameter, double> named;

  bool HasValues() const { return alone || !named.empty(); }
  /// Formats it as "--at 3.2" or "--at lens_position=3.2,temperature=40".
  std::string Text() const;
};

/// Parses VALUE, or NAME=VALUE separated by commas. Throws Error(kUsage).
RequestedOperatingPoint ParseRequestedOperatingPoint(const std::string& text);

/// Returns the variables of a camera, fixed where specified. Throws
/// Error(kUsage) for a variable that the camera does not depend on, and for a
/// value without a name if there are two variables; name: of the camera, for
/// messages.
FixedOperatingPoint FixRequestedPoint(const RequestedOperatingPoint& at,
                                      const std::vector<OperatingRange>& ranges,
                                      const std::string& name);
/// Returns the requested values of variables that a camera with these ranges
/// depends on.
RequestedOperatingPoint FilterByRanges(
    const RequestedOperatingPoint& at,
    const std::vector<OperatingRange>& ranges);
/// Like FixRequestedPoint(), but also throws Error(kUsage) for values outside
/// the ranges.
FixedOperatingPoint FixRequestedPointInRange(
    const RequestedOperatingPoint& at,
    const std::vector<OperatingRange>& ranges, const std::string& name);

/// Formats ranges: "0 to 10 dioptres and 20 to 70 °C".
std::string ToString(const std::vector<OperatingRange>& ranges);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_REQUESTED_OPERATING_POINT_H
