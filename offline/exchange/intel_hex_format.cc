#include "exchange/intel_hex_format.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/error.h"

namespace raygrid {
namespace {

enum class Record : uint8_t { kData = 0, kEnd = 1, kUpperAddress = 4 };

// A record: byte count, address, record type, data and checksum.
std::string Line(Record kind, uint16_t address, std::string_view bytes) {
  std::string line;
  uint8_t sum = 0;
  const auto add = [&](uint8_t byte) {
    line += fmt::format("{:02X}", byte);
    sum = static_cast<uint8_t>(sum + byte);
  };
  add(static_cast<uint8_t>(bytes.size()));
  add(static_cast<uint8_t>(address >> 8));
  add(static_cast<uint8_t>(address & 255));
  add(static_cast<uint8_t>(kind));
  for (const char byte : bytes) add(static_cast<uint8_t>(byte));
  add(static_cast<uint8_t>(-sum));
  return ":" + line + "\n";
}

std::string UpperAddressLine(uint32_t address) {
  const char upper[] = {static_cast<char>(address >> 24),
                        static_cast<char>(address >> 16 & 255)};
  return Line(Record::kUpperAddress, 0, {upper, sizeof(upper)});
}

void CheckAddress(const BlobTable& blob) {
  const std::string place = fmt::format("--address 0x{:08X}: ", blob.address);
  if (blob.address % BlobTable::kAlignment != 0)
    throw Error(ExitCode::kUsage,
                place + fmt::format("blobs must be aligned to {} bytes",
                                    BlobTable::kAlignment));
  constexpr uint64_t kEnd = uint64_t{1} << 32;
  if (blob.address + uint64_t{blob.bytes.size()} > kEnd)
    throw Error(
        ExitCode::kUsage,
        place +
            fmt::format("the blob of {} bytes exceeds the 32-bit address space",
                        blob.bytes.size()));
}

TableOutput WriteIntelHex(const BlobTable& blob) {
  // Records start at multiples of this number, so none crosses a 64 KiB
  // boundary.
  constexpr uint32_t kBytesPerLine = 16;
  CheckAddress(blob);
  std::string text = UpperAddressLine(blob.address);
  for (uint32_t done = 0; done < blob.bytes.size();) {
    const uint32_t address = blob.address + done;
    if (done > 0 && address % 0x10000 == 0) text += UpperAddressLine(address);
    const auto count = std::min<uint32_t>(
        kBytesPerLine - address % kBytesPerLine, blob.bytes.size() - done);
    text += Line(Record::kData, static_cast<uint16_t>(address & 0xFFFF),
                 std::string_view(blob.bytes).substr(done, count));
    done += count;
  }
  text += Line(Record::kEnd, 0, {});
  return {{{blob.path, text}},
          fmt::format("{} bytes at 0x{:08X}, CRC-32 {:08X}", blob.bytes.size(),
                      blob.address, blob.crc32)};
}

}  // namespace

TableFormat MakeIntelHexFormat() {
  TableFormat format;
  format.name = "hex";
  format.holds = "Intel HEX: a blob at a flash address, --address";
  format.options = {"address"};
  format.write_blob = WriteIntelHex;
  return format;
}

}  // namespace raygrid
