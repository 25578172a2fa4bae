#ifndef RAYGRID_TOOLS_CALIBRATION_SUMMARY_H
#define RAYGRID_TOOLS_CALIBRATION_SUMMARY_H

#include <string>

#include "evaluation/rig_result.h"

namespace raygrid {

/// Prints the metrics of a calibration whose files are in a folder: all metrics
/// of a single camera, or the main ones of a rig.
void PrintSummary(const RigResult& result, const std::string& folder);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CALIBRATION_SUMMARY_H
