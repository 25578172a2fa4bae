#ifndef RAYGRID_REPORT_STACK_SECTION_H
#define RAYGRID_REPORT_STACK_SECTION_H

#include <string>

#include "dataset/camera_file.h"

namespace raygrid {

/// "Over the range": charts of the focal length, of the centre and of the
/// distortion over the condition, a table with standard deviations, and maps of
/// the distortion at both ends.
std::string StackSection(const StackOfCameras& stack);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_STACK_SECTION_H
