#ifndef RAYGRID_DATASET_TEXT_ENCODING_H
#define RAYGRID_DATASET_TEXT_ENCODING_H

#include <string>
#include <string_view>

namespace raygrid {

/// Returns the position of the first byte that is not UTF-8 text, including
/// null bytes; npos if there is none.
size_t FindInvalidUtf8(std::string_view text);

/// Formats text as one line for a terminal: control characters and invalid
/// UTF-8 are escaped as \n, \x1b and so on.
std::string Printable(std::string_view text);

/// Throws InputError if a text file is not UTF-8, or begins with a byte order
/// mark.
void RequireTextFile(const std::string& path, std::string_view contents);

/// Limits of files of keys and values, such as cameras and patterns: parsers
/// need about 500 bytes per value. Grids with 100,000 control points and
/// patterns with 100,000 points are within them.
constexpr size_t kMaxTreeFileBytes = 64 << 20,
                 kMaxStructureCharacters = 1000000;
/// Characters adjacent to values of YAML, JSON or TOML, and of XML.
constexpr char kYamlStructureCharacters[] = "\n,:[{?", kXmlMarks[] = "<=";

/// Throws InputError, with the limit, if a text of keys and values has more
/// than max_bytes, or too many marks, characters adjacent to values. A '-'
/// before white space also counts. path may be empty for callers that add it to
/// errors later.
void RequireSmallTree(const std::string& path, std::string_view text,
                      const char* marks = kYamlStructureCharacters,
                      size_t max_bytes = kMaxTreeFileBytes);

/// Throws InputError if a name is not UTF-8, and thus cannot be written to
/// outputs; what: used in the error, as in "image".
void RequireStorableName(const std::string& what, const std::string& name);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_TEXT_ENCODING_H
