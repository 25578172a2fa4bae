#include "dataset/text_encoding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "dataset/error.h"

namespace raygrid {
namespace {

struct Character {
  uint32_t code = 0;
  size_t num_bytes = 0;  // 0: invalid UTF-8
};

// Decodes the first character of a non-empty text.
Character FirstCharacter(std::string_view text) {
  const auto lead = static_cast<uint8_t>(text[0]);
  if (lead < 0x80) return {lead, 1};
  const size_t num_bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < num_bytes) return {};
  uint32_t code = lead & (0x7fu >> num_bytes);
  for (size_t k = 1; k < num_bytes; ++k) {
    const auto byte = static_cast<uint8_t>(text[k]);
    if ((byte & 0xc0) != 0x80) return {};
    code = code << 6 | (byte & 0x3f);
  }
  const bool is_overlong =
      (num_bytes == 3 && code < 0x800) || (num_bytes == 4 && code < 0x10000);
  const bool is_surrogate = code >= 0xd800 && code <= 0xdfff;
  if (is_overlong || is_surrogate || code > 0x10ffff) return {};
  return {code, num_bytes};
}

// Whether a character is a control character of ASCII or Latin-1, a line or
// paragraph separator, or a bidirectional formatting character.
bool IsControl(uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x200e ||
         code == 0x200f || (code >= 0x2028 && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

size_t FindInvalidUtf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const Character character = FirstCharacter(text.substr(i));
    if (character.num_bytes == 0 || character.code == 0) return i;
    i += character.num_bytes;
  }
  return std::string_view::npos;
}

std::string Printable(std::string_view text) {
  std::string printable;
  for (size_t i = 0; i < text.size();) {
    const Character character = FirstCharacter(text.substr(i));
    const size_t num_bytes = std::max<size_t>(1, character.num_bytes);
    if (text[i] == '\n')
      printable += "\\n";
    else if (character.num_bytes > 0 && !IsControl(character.code))
      printable += text.substr(i, num_bytes);
    else
      for (size_t k = 0; k < num_bytes; ++k)
        printable +=
            fmt::format("\\x{:02x}", static_cast<uint8_t>(text[i + k]));
    i += num_bytes;
  }
  return printable;
}

void RequireTextFile(const std::string& path, std::string_view contents) {
  for (const char* mark : {"\xef\xbb\xbf", "\xff\xfe", "\xfe\xff"})
    if (contents.substr(0, std::string_view(mark).size()) == mark)
      throw InputError(
          path +
          ": begins with a byte order mark; save it as UTF-8 without BOM");
  const size_t position = FindInvalidUtf8(contents);
  if (position == std::string_view::npos) return;
  const auto line =
      1 + std::count(contents.begin(),
                     contents.begin() + static_cast<std::ptrdiff_t>(position),
                     '\n');
  throw InputError(fmt::format(
      "{}, line {}: not UTF-8; save the file in this encoding", path, line));
}

void RequireSmallTree(const std::string& path, std::string_view text,
                      const char* marks, size_t max_bytes) {
  const std::string prefix = path.empty() ? "" : path + ": ";
  if (text.size() > max_bytes)
    throw InputError(fmt::format(
        "{}file size of {:.0f} MB exceeds the limit of {} MB for cameras, "
        "patterns and sessions; check that this is the right file",
        prefix, std::ceil(static_cast<double>(text.size()) / (1 << 20)),
        max_bytes >> 20));
  std::array<bool, 256> is_mark = {};
  for (; *marks; ++marks) is_mark[static_cast<uint8_t>(*marks)] = true;
  const std::string_view spaces = " \t\r\n";
  size_t count = 0;
  for (size_t k = 0; k < text.size(); ++k) {
    if (is_mark[static_cast<uint8_t>(text[k])])
      ++count;
    else if (text[k] == '-' && k + 1 < text.size() &&
             spaces.find(text[k + 1]) != std::string_view::npos)
      ++count;
  }
  if (count > kMaxStructureCharacters)
    throw InputError(
        fmt::format("{}about {} values exceed the limit of {} for cameras, "
                    "patterns and sessions; check that this is the right file",
                    prefix, count, kMaxStructureCharacters));
}

void RequireStorableName(const std::string& what, const std::string& name) {
  if (FindInvalidUtf8(name) != std::string::npos)
    throw InputError(fmt::format(
        "{} '{}': the name is not UTF-8, as result files require; rename it",
        what, Printable(name)));
}

}  // namespace raygrid
