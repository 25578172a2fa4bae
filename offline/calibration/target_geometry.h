#ifndef RAYGRID_CALIBRATION_TARGET_GEOMETRY_H
#define RAYGRID_CALIBRATION_TARGET_GEOMETRY_H

#include "dataset/pattern.h"
#include "evaluation/verdict.h"

namespace raygrid {

/// Warns of boards whose points are estimated far from where the pattern says:
/// no printer is off by as much, and the estimate holds on to the pattern.
void WarnOfOtherGeometry(const Pattern& given, const Pattern& found,
                         Verdict* verdict);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_TARGET_GEOMETRY_H
