#ifndef RAYGRID_TOOLS_CAPTURE_OPTIONS_H
#define RAYGRID_TOOLS_CAPTURE_OPTIONS_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/capture.h"

namespace raygrid {

/// Help block with the syntax of --capture-settings.
extern const char kCaptureSyntaxHelp[];

/// Keys of --capture-settings, for messages.
extern const char kCaptureKeysHelp[];

/// Returns the known capture settings, overridden by texts such as
/// "crop=0,0,3280,2464,lens=2,orientation=1"; nullopt for "none". Throws
/// Error(kUsage) for values that are impossible with images of this size.
std::optional<Capture> ParseCaptureKeys(const std::vector<std::string>& texts,
                                        const std::optional<Capture>& known,
                                        const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CAPTURE_OPTIONS_H
