/// --at: the values of conditions at which a camera is meant.
#ifndef RAYGRID_TOOLS_CONDITIONS_AT_H
#define RAYGRID_TOOLS_CONDITIONS_AT_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_stack.h"

namespace raygrid {

/// A value of the only condition, or values by the conditions' names; empty if
/// none are given.
struct ConditionsAt {
  std::optional<double> alone;
  std::map<CameraCondition, double> named;

  bool IsGiven() const { return alone || !named.empty(); }
  /// "--at 3.2", "--at lens_position=3.2,temperature=40".
  std::string Text() const;
};

/// Reads VALUE, or NAME=VALUE with commas between several. Throws
/// Error(kUsage).
ConditionsAt ParseConditionsAt(const std::string& text);

/// The conditions of a camera, held where they are given. Throws Error(kUsage)
/// for one that the camera does not change with, and for a value without a name
/// where there are two; name is the camera's, for messages.
HeldConditions HeldOf(const ConditionsAt& at,
                      const std::vector<ConditionRange>& ranges,
                      const std::string& name);
/// The values that are given of conditions which a camera with these ranges
/// changes with.
ConditionsAt OfRanges(const ConditionsAt& at,
                      const std::vector<ConditionRange>& ranges);
/// HeldOf(), and throws Error(kUsage) for values that are not in the ranges.
HeldConditions HeldInRange(const ConditionsAt& at,
                           const std::vector<ConditionRange>& ranges,
                           const std::string& name);

/// "0 to 10 dioptres and 20 to 70 °C".
std::string TextOf(const std::vector<ConditionRange>& ranges);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CONDITIONS_AT_H
