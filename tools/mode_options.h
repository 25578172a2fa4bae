#ifndef RAYGRID_TOOLS_MODE_OPTIONS_H
#define RAYGRID_TOOLS_MODE_OPTIONS_H

#include <string>
#include <vector>

#include "camera/sensor_mode.h"

namespace raygrid {

/// Help for the keys of a mode.
extern const char kModeKeysHelp[];
/// Help block with the syntax of pack --mode.
extern const char kModeSyntaxHelp[];

/// Parses a mode: a name up to the last colon, and its mapping to frames of
/// calibrated_size, such as "half:bin=2" or "roi:crop=320,180,640,360,flip=h".
/// Throws Error(kUsage).
SensorMode ParseMode(const std::string& text, const ImageSize& calibrated_size);

/// Parses the modes of a blob. Throws Error(kUsage), also for duplicate names.
std::vector<SensorMode> ParseModes(const std::vector<std::string>& texts,
                                   const ImageSize& calibrated_size);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_MODE_OPTIONS_H
