#ifndef RAYGRID_REPORT_STACK_SECTION_H
#define RAYGRID_REPORT_STACK_SECTION_H

#include <string>

#include "dataset/camera_file.h"

namespace raygrid {

/// "Over the range": charts of the focal length, of the centre and of the
/// distortion over the condition, and a table with standard deviations.
std::string StackSection(const StackOfCameras& stack);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_STACK_SECTION_H
