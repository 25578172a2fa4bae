#include "table_export.h"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "camera_input.h"
#include "crc32.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

// An address of 32 bits as flash programmers write it, or a decimal number.
uint32_t ParseAddress(const std::string& text) {
  const bool is_hex =
      text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
  const char *const begin = text.data() + (is_hex ? 2 : 0), *const end =
                                                                text.data() +
                                                                text.size();
  uint32_t address = 0;
  const auto [next, fault] =
      std::from_chars(begin, end, address, is_hex ? 16 : 10);
  if (fault != std::errc() || next != end)
    throw Error(ExitCode::kUsage,
                fmt::format("--address {}: expected a number of 32 bits, as "
                            "0x08080000",
                            text));
  return address;
}

BlobTable TableOfBlob(const TableFormat& format,
                      const TableArguments& arguments) {
  BlobTable table;
  if (!arguments.address.empty())
    table.address = ParseAddress(arguments.address);
  else if (format.Takes("address"))
    throw Error(ExitCode::kUsage,
                fmt::format("--to {}: say where in flash the blob is to lie, "
                            "as --address 0x08080000",
                            format.name));
  table.path = arguments.output;
  table.bytes = ReadFile(arguments.input);
  const CameraInput camera = ParseCamera(arguments.input, table.bytes);
  if (!camera.blob)
    throw InputError(
        fmt::format("{}: is no blob, which {} is made of; "
                    "'raygrid pack' makes one",
                    arguments.input, format.name));
  table.camera = camera.file.name;
  table.serial = camera.file.serial;
  table.image_size = camera.blob->image_size();
  table.crc32 =
      rg_crc32(0, reinterpret_cast<const uint8_t*>(table.bytes.data()),
               static_cast<uint32_t>(table.bytes.size()));
  return table;
}

TableOutput MakeTable(const TableFormat& format,
                      const TableArguments& arguments,
                      nlohmann::ordered_json* json) {
  const BlobTable table = TableOfBlob(format, arguments);
  (*json)["bytes"] = table.bytes.size();
  (*json)["crc32"] = table.crc32;
  return format.write_blob(table);
}

}  // namespace

void ExportTable(const TableFormat& format, const TableArguments& arguments,
                 const CommonOptions& common) {
  nlohmann::ordered_json json = {{"format", format.name},
                                 {"files", nlohmann::ordered_json::array()}};
  const TableOutput made = MakeTable(format, arguments, &json);
  std::vector<std::string> paths;
  OutputFiles outputs;
  for (const auto& [path, contents] : made.files) {
    paths.push_back(path);
    json["files"].push_back(path);
    outputs.Add(path, contents);
  }
  RequireNoInputReplaced({arguments.input}, paths);
  outputs.Commit();
  if (common.json)
    fmt::print("{}\n", json.dump(2, ' ', false,
                                 nlohmann::json::error_handler_t::replace));
  else if (!common.quiet)
    fmt::print("{}: {}\n", Printable(arguments.output), made.told);
}

}  // namespace raygrid
