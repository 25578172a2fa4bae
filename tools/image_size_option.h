#ifndef RAYGRID_TOOLS_IMAGE_SIZE_OPTION_H
#define RAYGRID_TOOLS_IMAGE_SIZE_OPTION_H

#include <string>

#include "camera/area.h"

namespace raygrid {

/// "640x480"; throws Error(kUsage) naming the option, for larger sizes than
/// images may have too.
ImageSize ParseImageSize(const std::string& option, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_IMAGE_SIZE_OPTION_H
