/// Options whose value is a list of keys: "640x480,center=320,240,hfov=90".
#ifndef RAYGRID_TOOLS_KEY_OPTIONS_H
#define RAYGRID_TOOLS_KEY_OPTIONS_H

#include <string>
#include <vector>

namespace raygrid {

/// Splits a text at the commas before keys: "640x480", "center=320,240",
/// "hfov=90". A later item without '=' belongs to the preceding key.
std::vector<std::string> SplitAtKeys(const std::string& text);

/// Parses `count` numbers separated by commas. Throws Error(kUsage), with an
/// example; the message begins with `place`.
std::vector<double> ParseNumbers(const std::string& place,
                                 const std::string& text, size_t count,
                                 const char* example);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_KEY_OPTIONS_H
