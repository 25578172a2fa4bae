#ifndef RAYGRID_TOOLS_IMAGE_SIZE_OPTION_H
#define RAYGRID_TOOLS_IMAGE_SIZE_OPTION_H

#include <string>

#include "camera/area.h"

namespace raygrid {

/// Parses an image size such as "640x480". Throws Error(kUsage), with the name
/// of the option, also if the size exceeds the maximum.
ImageSize ParseImageSize(const std::string& option, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_IMAGE_SIZE_OPTION_H
