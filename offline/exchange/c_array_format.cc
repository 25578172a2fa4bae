#include "exchange/c_array_format.h"

#include <fmt/format.h>

#include <filesystem>

namespace raygrid {
namespace {

bool IsLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Converts a file name to a C identifier: front.h defines front_raygrid, whose
// suffix avoids keywords. C++ reserves names with two consecutive '_'.
std::string ArrayName(const std::filesystem::path& path) {
  std::string name;
  for (const char c : path.stem().string() + "_raygrid") {
    const bool is_plain = IsLetter(c) || IsDigit(c);
    if (name.empty() && !IsLetter(c)) name = "camera_";
    if (is_plain || name.back() != '_') name += is_plain ? c : '_';
  }
  return name;
}

std::string ToUpper(std::string name) {
  for (char& c : name)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return name;
}

// Sanitizes text for a C comment: no comment delimiters or trigraphs.
std::string EscapeComment(std::string text) {
  for (char& c : text)
    if (!IsLetter(c) && !IsDigit(c) && c != ' ' && c != '-' && c != '.')
      c = '_';
  return text;
}

std::string BlobComment(const BlobTable& blob) {
  std::string text =
      fmt::format("/* Camera {}, {} x {} px, as a raygrid blob.",
                  blob.camera.empty() ? "without a name"
                                      : '"' + EscapeComment(blob.camera) + '"',
                  blob.image_size.width, blob.image_size.height);
  if (!blob.serial.empty())
    text += fmt::format("\n * Serial number: {}", EscapeComment(blob.serial));
  return text +
         "\n * For rg_camera_open(). CRC-32 as in zlib, over all bytes. */\n";
}

std::string Constants(const std::string& capitals, const BlobTable& blob) {
  return fmt::format(
      "#define {0}_SIZE {1}\n#define {0}_CRC32 0x{2:08X}UL\n"
      "#define {0}_WIDTH {3}\n#define {0}_HEIGHT {4}\n",
      capitals, blob.bytes.size(), blob.crc32, blob.image_size.width,
      blob.image_size.height);
}

// Returns the declarator, up to and including the alignment attribute.
std::string FormatDeclarator(const std::string& name) {
  return fmt::format(
      "const uint8_t {}[{}_SIZE]\n    __attribute__((aligned({})))", name,
      ToUpper(name), BlobTable::kAlignment);
}

std::string Bytes(const std::string& bytes) {
  constexpr size_t kBytesPerLine = 12;
  std::string text = " = {";
  for (size_t k = 0; k < bytes.size(); ++k)
    text += fmt::format("{}0x{:02x},", k % kBytesPerLine == 0 ? "\n    " : " ",
                        static_cast<uint8_t>(bytes[k]));
  return text + "\n};\n";
}

std::string Header(const std::string& name, const BlobTable& blob,
                   const std::string& declaration) {
  const std::string capitals = ToUpper(name);
  return fmt::format(
      "{0}#ifndef {1}_H\n#define {1}_H\n\n#include <stdint.h>\n"
      "\n{2}\n{3}\n#endif /* {1}_H */\n",
      BlobComment(blob), capitals, Constants(capitals, blob), declaration);
}

// Writes a header with the data, or a source file with the data and a header
// that declares it.
TableOutput WriteCArray(const BlobTable& blob) {
  std::filesystem::path path = blob.path;
  const std::string ending = path.extension().string();
  const std::string name = ArrayName(path);
  TableOutput output;
  if (ending == ".h") {
    output.files.emplace_back(
        blob.path,
        Header(name, blob,
               "static " + FormatDeclarator(name) + Bytes(blob.bytes)));
  } else {
    const std::filesystem::path header =
        std::filesystem::path(path).replace_extension(".h");
    output.files.emplace_back(
        blob.path, fmt::format("{}#include \"{}\"\n\n{}{}", BlobComment(blob),
                               header.filename().string(),
                               FormatDeclarator(name), Bytes(blob.bytes)));
    output.files.emplace_back(
        header.string(),
        Header(name, blob,
               "#ifdef __cplusplus\nextern \"C\" {\n#endif\nextern " +
                   FormatDeclarator(name) +
                   ";\n#ifdef __cplusplus\n}\n#endif\n"));
  }
  output.configuration =
      fmt::format("{}, {} bytes, alignment {}, CRC-32 {:08X}", name,
                  blob.bytes.size(), BlobTable::kAlignment, blob.crc32);
  return output;
}

}  // namespace

TableFormat MakeCArrayFormat() {
  TableFormat format;
  format.name = "c";
  format.holds =
      "C and C++: a blob as a constant array in NAME.h, or in NAME.c with "
      "NAME.h";
  format.endings = {".h", ".c"};
  format.write_blob = WriteCArray;
  return format;
}

}  // namespace raygrid
