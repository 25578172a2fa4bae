#ifndef RAYGRID_TOOLS_CALIBRATION_SUMMARY_H
#define RAYGRID_TOOLS_CALIBRATION_SUMMARY_H

#include <string>

#include "evaluation/rig_result.h"

namespace raygrid {

/// Prints the figures of a calibration whose files are in a folder: all of a
/// single camera's, or the main ones of a rig's.
void PrintSummary(const RigResult& result, const std::string& folder);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CALIBRATION_SUMMARY_H
