#ifndef RAYGRID_TOOLS_CAPTURE_OPTIONS_H
#define RAYGRID_TOOLS_CAPTURE_OPTIONS_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/capture.h"

namespace raygrid {

/// The syntax of --capture-settings, a block of help.
extern const char kCaptureSyntaxHelp[];

/// The words of --capture-settings, for messages.
extern const char kCaptureWordsHelp[];

/// The known capture, with what "crop=0,0,3280,2464,lens=2,orientation=1" says
/// instead; nothing for "none". Throws Error(kUsage) for values that no camera
/// with images of that size has.
std::optional<Capture> ParseCaptureWords(const std::vector<std::string>& texts,
                                         const std::optional<Capture>& known,
                                         const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CAPTURE_OPTIONS_H
