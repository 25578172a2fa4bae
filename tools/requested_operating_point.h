/// --at: the values of conditions at which a camera is meant.
#ifndef RAYGRID_TOOLS_REQUESTED_OPERATING_POINT_H
#define RAYGRID_TOOLS_REQUESTED_OPERATING_POINT_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "camera/operating_point_model.h"

namespace raygrid {

/// A value of the only condition, or values by the conditions' names; empty if
/// none are given.
struct RequestedOperatingPoint {
  std::optional<double> alone;
  std::map<OperatingParameter, double> named;

  bool IsGiven() const { return alone || !named.empty(); }
  /// "--at 3.2", "--at lens_position=3.2,temperature=40".
  std::string Text() const;
};

/// Reads VALUE, or NAME=VALUE with commas between several. Throws
/// Error(kUsage).
RequestedOperatingPoint ParseRequestedOperatingPoint(const std::string& text);

/// The conditions of a camera, held where they are given. Throws Error(kUsage)
/// for one that the camera does not change with, and for a value without a name
/// where there are two; name is the camera's, for messages.
FixedOperatingPoint FixRequestedPoint(const RequestedOperatingPoint& at,
                                      const std::vector<OperatingRange>& ranges,
                                      const std::string& name);
/// The values that are given of conditions which a camera with these ranges
/// changes with.
RequestedOperatingPoint FilterByRanges(
    const RequestedOperatingPoint& at,
    const std::vector<OperatingRange>& ranges);
/// FixRequestedPoint(), and throws Error(kUsage) for values that are not in the
/// ranges.
FixedOperatingPoint FixRequestedPointInRange(
    const RequestedOperatingPoint& at,
    const std::vector<OperatingRange>& ranges, const std::string& name);

/// "0 to 10 dioptres and 20 to 70 °C".
std::string ToText(const std::vector<OperatingRange>& ranges);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_REQUESTED_OPERATING_POINT_H
