#ifndef RAYGRID_REPORT_RESULT_JSON_H
#define RAYGRID_REPORT_RESULT_JSON_H

#include <cstdint>
#include <string>

#include "evaluation/calibration_result.h"

namespace raygrid {

/// result.json. The memory figure and the seconds differ from run to run;
/// everything else is the same for the same input.
std::string FormatResultJson(const CalibrationResult& result, uint64_t seed,
                             int64_t peak_memory_bytes);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_JSON_H
