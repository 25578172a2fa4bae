/// Options whose value is a list of words, as "640x480,center=320,240,hfov=90".
#ifndef RAYGRID_TOOLS_WORD_OPTIONS_H
#define RAYGRID_TOOLS_WORD_OPTIONS_H

#include <string>
#include <vector>

namespace raygrid {

/// The parts of a text between the commas before words: "640x480",
/// "center=320,240", "hfov=90". A part without '=' behind the first one belongs
/// to the word before it.
std::vector<std::string> SplitAtWords(const std::string& text);

/// Numbers with commas between, as many as asked for. Throws Error(kUsage),
/// with an example for so many; place is what it begins with.
std::vector<double> ParseNumbers(const std::string& place,
                                 const std::string& text, size_t count,
                                 const char* example);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_WORD_OPTIONS_H
