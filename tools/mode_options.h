#ifndef RAYGRID_TOOLS_MODE_OPTIONS_H
#define RAYGRID_TOOLS_MODE_OPTIONS_H

#include <string>
#include <vector>

#include "camera/sensor_mode.h"

namespace raygrid {

/// The help for the words of a mode.
extern const char kModeWordsHelp[];
/// The syntax of pack --mode, a block of help.
extern const char kModeSyntaxHelp[];

/// "half:bin=2", "roi:crop=320,180,640,360,flip=h": a name, up to the last
/// colon, and how the mode's frames lie in those of calibrated_size. Throws
/// Error(kUsage).
SensorMode ParseMode(const std::string& text, const ImageSize& calibrated_size);

/// Several modes that a blob can hold; throws Error(kUsage) for one that is
/// named twice, too.
std::vector<SensorMode> ParseModes(const std::vector<std::string>& texts,
                                   const ImageSize& calibrated_size);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_MODE_OPTIONS_H
