#ifndef RAYGRID_REPORT_RESULT_JSON_H
#define RAYGRID_REPORT_RESULT_JSON_H

#include <cstdint>
#include <string>

#include "evaluation/calibration_result.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// result.json. The memory figure and the seconds differ from run to run;
/// everything else is the same for the same input.
std::string FormatResultJson(const CalibrationResult& result, uint64_t seed,
                             int64_t peak_memory_bytes);
/// A rig's: sums and errors over all cameras, held out with each board
/// localised once for all cameras; how the cameras stand to each other; then
/// each camera's own, held out with its images localised alone.
std::string FormatResultJson(const RigResult& result, uint64_t seed,
                             int64_t peak_memory_bytes);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_JSON_H
