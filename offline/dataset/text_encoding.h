#ifndef RAYGRID_DATASET_TEXT_ENCODING_H
#define RAYGRID_DATASET_TEXT_ENCODING_H

#include <string>
#include <string_view>

namespace raygrid {

/// The position of the first byte that does not belong to UTF-8 text, the
/// byte 0 among them; npos if all do.
size_t FindNoUtf8(std::string_view text);

/// Text as one line for a terminal: control characters and what is not UTF-8
/// are written as \n, \x1b and so on.
std::string Printable(std::string_view text);

/// Throws InputError if a text file is not UTF-8, or begins with a byte order
/// mark.
void RequireTextFile(const std::string& path, std::string_view contents);

/// Bounds of a file of keys and values, such as a camera or a pattern: parsers
/// take about 500 bytes for each of its values. A grid of 100,000 control
/// points and a pattern of as many points keep them.
constexpr size_t kMaxTreeBytes = 64 << 20, kMaxTreeMarks = 1000000;
/// Characters before and behind values of YAML, JSON or TOML, and of XML.
constexpr char kTreeMarks[] = "\n,:[{?", kXmlMarks[] = "<=";

/// Throws InputError, naming the limit, if a text of keys and values has more
/// bytes, or more marks before and behind values, than these. A '-' before
/// white space is a mark, too. An empty
/// path is none, for readers whose errors get it later.
void RequireSmallTree(const std::string& path, std::string_view text,
                      const char* marks = kTreeMarks,
                      size_t max_bytes = kMaxTreeBytes);

/// Throws InputError if a name is not UTF-8, and so fits in no output; what is
/// used in the error, as in "image".
void RequireStorableName(const std::string& what, const std::string& name);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_TEXT_ENCODING_H
