#ifndef RAYGRID_REPORT_OPERATING_POINT_SECTION_H
#define RAYGRID_REPORT_OPERATING_POINT_SECTION_H

#include <string>

#include "dataset/camera_file.h"

namespace raygrid {

/// Formats "Over the range": charts of focal length, principal point and
/// distortion over the condition, a table with standard deviations, and maps of
/// the distortion at both ends.
std::string MakeOperatingPointSection(const OperatingPointCalibration& stack);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_OPERATING_POINT_SECTION_H
