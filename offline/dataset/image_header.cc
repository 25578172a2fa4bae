#include "dataset/image_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <stdexcept>

#include "dataset/error.h"

namespace raygrid {
namespace {

std::atomic<bool> huge_is_allowed{false};

enum class Order { kBigEndian, kLittleEndian };

// Reads integers of a file; throws std::out_of_range at the end.
class Bytes {
 public:
  Bytes(const std::string& bytes, Order order) : bytes_(bytes), order_(order) {}

  uint64_t ReadNumber(size_t at, size_t count) const {
    uint64_t number = 0;
    for (size_t i = 0; i < count; ++i) {
      const size_t k = order_ == Order::kBigEndian ? i : count - 1 - i;
      number = number << 8 | static_cast<uint8_t>(bytes_.at(at + k));
    }
    return number;
  }
  bool HasTextAt(size_t at, const char* text, size_t size) const {
    return at <= bytes_.size() && bytes_.compare(at, size, text, size) == 0;
  }
  size_t size() const { return bytes_.size(); }

 private:
  const std::string& bytes_;
  Order order_;
};

// Fields of the file header before any limit is checked.
struct RawHeader {
  uint64_t width = 0, height = 0;
  // TIFF tiles are decoded as a whole, even if the image is smaller.
  uint64_t tile_width = 0, tile_height = 0;
  int orientation = 1;
  size_t orientation_at = 0, orientation_bytes = 0;
  size_t exif_at = 0, exif_bytes = 0;
};

// ---- TIFF, and EXIF, which is TIFF without an image -------------------------

// Returns the size of an integer type of directory entries in bytes; 0 for
// other types.
size_t GetTypeSize(uint64_t type) {
  switch (type) {
    case 1:  // BYTE
      return 1;
    case 3:  // SHORT
      return 2;
    case 4:  // LONG
      return 4;
    case 16:  // LONG8
      return 8;
    default:
      return 0;
  }
}

bool IsSizeTag(uint64_t tag) {
  return tag == 256 || tag == 257 || tag == 322 || tag == 323;
}

// Parses the first directory of the TIFF data at start.
void ParseTiff(const std::string& bytes, size_t start, RawHeader* header) {
  const Order order = bytes.compare(start, 2, "II") == 0 ? Order::kLittleEndian
                                                         : Order::kBigEndian;
  const Bytes file(bytes, order);
  const bool is_big = file.ReadNumber(start + 2, 2) == 43;  // BigTIFF
  const size_t offset_bytes = is_big ? 8 : 4;
  const size_t count_bytes = is_big ? 8 : 2;
  const size_t entry_bytes = is_big ? 20 : 12;
  const uint64_t offset =
      file.ReadNumber(start + (is_big ? 8 : 4), offset_bytes);
  if (offset > bytes.size()) throw std::out_of_range("TIFF directory");
  const size_t directory = start + offset;
  const uint64_t num_entries = file.ReadNumber(directory, count_bytes);
  for (uint64_t i = 0; i < num_entries; ++i) {
    const size_t entry = directory + count_bytes + i * entry_bytes;
    const size_t value_at = entry + entry_bytes - offset_bytes;
    const size_t value_bytes = GetTypeSize(file.ReadNumber(entry + 2, 2));
    const uint64_t tag = file.ReadNumber(entry, 2);
    const bool is_number = value_bytes > 0 && value_bytes <= offset_bytes;
    if (!is_number && IsSizeTag(tag)) throw std::out_of_range("TIFF size");
    if (!is_number) continue;
    const uint64_t value = file.ReadNumber(value_at, value_bytes);
    switch (tag) {
      case 256:
        header->width = std::max(header->width, value);
        break;
      case 257:
        header->height = std::max(header->height, value);
        break;
      case 274:
        if (value < 1 || value > 8) break;
        header->orientation = static_cast<int>(value);
        header->orientation_at = value_at;
        header->orientation_bytes = value_bytes;
        break;
      case 322:
        header->tile_width = std::max(header->tile_width, value);
        break;
      case 323:
        header->tile_height = std::max(header->tile_height, value);
        break;
      default:
        break;
    }
  }
}

// Parses EXIF data, which may be truncated. Corrupt tags are ignored.
void ParseExif(const std::string& bytes, size_t start, size_t count,
               RawHeader* header) {
  if (start > bytes.size()) return;
  header->exif_at = start;
  header->exif_bytes = std::min(count, bytes.size() - start);
  RawHeader exif;
  try {
    ParseTiff(bytes, start, &exif);
  } catch (const std::out_of_range&) {
    return;
  }
  header->orientation = exif.orientation;
}

// ---- The other kinds --------------------------------------------------------

void ParsePng(const std::string& bytes, RawHeader* header) {
  const Bytes file(bytes, Order::kBigEndian);
  header->width = file.ReadNumber(16, 4);
  header->height = file.ReadNumber(20, 4);
  for (size_t chunk = 8; chunk + 12 <= file.size();
       chunk += 12 + file.ReadNumber(chunk, 4)) {
    if (file.HasTextAt(chunk + 4, "eXIf", 4))
      ParseExif(bytes, chunk + 8, file.ReadNumber(chunk, 4), header);
    if (file.HasTextAt(chunk + 4, "IEND", 4)) break;
  }
}

// Parses segments up to the frame header.
void ParseJpeg(const std::string& bytes, RawHeader* header) {
  const Bytes file(bytes, Order::kBigEndian);
  for (size_t at = 2;;) {
    while (file.ReadNumber(at, 1) != 0xff) ++at;
    while (file.ReadNumber(at, 1) == 0xff) ++at;
    const uint64_t marker = file.ReadNumber(at++, 1);
    const bool stands_alone = marker <= 1 || (marker >= 0xd0 && marker <= 0xd9);
    if (stands_alone) continue;
    const bool is_frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 &&
                          marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      header->height = file.ReadNumber(at + 3, 2);
      header->width = file.ReadNumber(at + 5, 2);
      return;
    }
    const uint64_t length = file.ReadNumber(at, 2);
    if (marker == 0xe1 && length >= 8 && file.HasTextAt(at + 2, "Exif\0\0", 6))
      ParseExif(bytes, at + 8, length - 8, header);
    at += length;
  }
}

void ParseBmp(const std::string& bytes, RawHeader* header) {
  const Bytes file(bytes, Order::kLittleEndian);
  const bool is_old = file.ReadNumber(14, 4) == 12;
  header->width = is_old ? file.ReadNumber(18, 2) : file.ReadNumber(18, 4);
  header->height = is_old ? file.ReadNumber(20, 2) : file.ReadNumber(22, 4);
  // A negative height indicates rows from top to bottom.
  if (!is_old && header->height >> 31)
    header->height = (uint64_t{1} << 32) - header->height;
}

// Parses the header of PBM, PGM and PPM files.
void ParsePnm(const std::string& bytes, RawHeader* header) {
  size_t at = 2;
  for (uint64_t* number : {&header->width, &header->height}) {
    while (std::isspace(static_cast<uint8_t>(bytes.at(at))) ||
           bytes[at] == '#') {
      if (bytes[at] == '#')
        while (bytes.at(at) != '\n') ++at;
      ++at;
    }
    for (; std::isdigit(static_cast<uint8_t>(bytes.at(at))); ++at)
      *number = std::min<uint64_t>(10 * *number + (bytes[at] - '0'),
                                   uint64_t{1} << 32);
  }
}

void ParseWebp(const std::string& bytes, RawHeader* header) {
  const Bytes file(bytes, Order::kLittleEndian);
  if (file.HasTextAt(12, "VP8 ", 4)) {
    header->width = file.ReadNumber(26, 2) & 0x3fff;
    header->height = file.ReadNumber(28, 2) & 0x3fff;
  } else if (file.HasTextAt(12, "VP8L", 4)) {
    const uint64_t sizes = file.ReadNumber(21, 4);
    header->width = (sizes & 0x3fff) + 1;
    header->height = (sizes >> 14 & 0x3fff) + 1;
  } else if (file.HasTextAt(12, "VP8X", 4)) {
    header->width = file.ReadNumber(24, 3) + 1;
    header->height = file.ReadNumber(27, 3) + 1;
  }
  for (size_t chunk = 12; chunk + 8 <= file.size();) {
    const uint64_t size = file.ReadNumber(chunk + 4, 4);
    if (file.HasTextAt(chunk, "EXIF", 4)) {
      const size_t name = file.HasTextAt(chunk + 8, "Exif\0\0", 6) ? 6 : 0;
      ParseExif(bytes, chunk + 8 + name, size - name, header);
    }
    chunk += 8 + size + size % 2;
  }
}

// Returns false for files of unsupported types.
bool ParseHeader(const std::string& bytes, RawHeader* header) {
  const Bytes file(bytes, Order::kBigEndian);
  const auto starts = [&file](const char* text, size_t size) {
    return file.HasTextAt(0, text, size);
  };
  if (starts("\x89PNG\r\n\x1a\n", 8))
    ParsePng(bytes, header);
  else if (starts("\xff\xd8", 2))
    ParseJpeg(bytes, header);
  else if (starts("II*\0", 4) || starts("MM\0*", 4) || starts("II+\0", 4) ||
           starts("MM\0+", 4))
    ParseTiff(bytes, 0, header);
  else if (starts("BM", 2))
    ParseBmp(bytes, header);
  else if (starts("P", 1) && bytes.size() > 2 && bytes[1] >= '1' &&
           bytes[1] <= '6')
    ParsePnm(bytes, header);
  else if (starts("RIFF", 4) && file.HasTextAt(8, "WEBP", 4))
    ParseWebp(bytes, header);
  else
    return false;
  return true;
}

void RequireAllowed(const std::string& name, uint64_t width, uint64_t height) {
  const std::string why = DescribeSizeLimit(width, height);
  if (!why.empty()) throw InputError(name + ": " + why);
}

// Rejects files with implausibly many pixels per byte: these are not
// photographs, and a file of kilobytes would need gigabytes of memory.
void RequirePlausibleFileSize(const std::string& name, const RawHeader& header,
                              size_t num_bytes) {
  constexpr struct {
    uint64_t num_pixels, max_pixels_per_byte;
  } kBounds[] = {{1 << 24, 500}, {1 << 26, 100}};
  const uint64_t num_pixels = header.width * header.height;
  const bool is_likely =
      std::all_of(std::begin(kBounds), std::end(kBounds), [&](const auto& b) {
        return num_pixels <= b.num_pixels ||
               num_pixels <= b.max_pixels_per_byte * num_bytes;
      });
  if (huge_is_allowed || is_likely) return;
  throw InputError(
      fmt::format("{}: {} x {} pixels in {} bytes is implausible for a "
                  "photograph; accept with --allow-huge-images",
                  name, header.width, header.height, num_bytes));
}

[[noreturn]] void ThrowDamaged(const std::string& name) {
  throw InputError(name + ": not an image, or corrupt; remove or replace it");
}

}  // namespace

void AllowHugeImages() { huge_is_allowed = true; }

std::string DescribeSizeLimit(uint64_t width, uint64_t height) {
  const uint64_t side = std::max(width, height);
  if (!huge_is_allowed && side > kMaxSidePx)
    return fmt::format(
        "size of {} x {} pixels exceeds the limit of {} per side; accept with "
        "--allow-huge-images",
        width, height, kMaxSidePx);
  if (side > kMaxHugeSidePx ||
      width * height > static_cast<uint64_t>(kMaxHugePixels))
    return fmt::format(
        "size of {} x {} pixels exceeds the limit of {} per side and {} in "
        "total, even with --allow-huge-images",
        width, height, kMaxHugeSidePx, kMaxHugePixels);
  return "";
}

ImageHeader ParseImageHeader(const std::string& name,
                             const std::string& bytes) {
  RawHeader raw;
  try {
    if (!ParseHeader(bytes, &raw)) ThrowDamaged(name);
  } catch (const std::out_of_range&) {
    ThrowDamaged(name);
  }
  if (raw.width == 0 || raw.height == 0) ThrowDamaged(name);
  RequireAllowed(name, raw.width, raw.height);
  RequirePlausibleFileSize(name, raw, bytes.size());
  RequireAllowed(name + ", a tile", raw.tile_width, raw.tile_height);
  ImageHeader header;
  header.size = {static_cast<int>(raw.width), static_cast<int>(raw.height)};
  header.orientation = raw.orientation;
  header.orientation_at = raw.orientation_at;
  header.orientation_bytes = raw.orientation_bytes;
  header.exif_at = raw.exif_at;
  header.exif_bytes = raw.exif_bytes;
  return header;
}

}  // namespace raygrid
