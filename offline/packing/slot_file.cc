#include "packing/slot_file.h"

#include <algorithm>
#include <cstring>

#include "blob_layout.h"
#include "bytes.h"
#include "crc32.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

constexpr char kErased = '\xff';
constexpr char kSlotMagic[] = "RGSLOTS";  // with the terminating zero

std::vector<uint32_t> CopyAligned(const std::string& bytes) {
  std::vector<uint32_t> words((bytes.size() + 3) / 4);
  std::memcpy(words.data(), bytes.data(), bytes.size());
  return words;
}

// Whether a slot header with a correct CRC is located at an offset.
bool HasHeaderAt(const std::string& bytes, size_t at) {
  if (bytes.compare(at, sizeof(kSlotMagic), kSlotMagic, sizeof(kSlotMagic)) !=
          0 ||
      bytes.size() - at < RG_SLOT_HEADER_SIZE)
    return false;
  const uint8_t* const header =
      reinterpret_cast<const uint8_t*>(bytes.data()) + at;
  return rg_load_u32(header + RG_SLOT_HEADER_CRC) ==
         rg_crc32(0, header, RG_SLOT_HEADER_CRC);
}

// Whether an offset may be the start of a corrupt or partially written slot.
bool MayBeSlotAt(const std::string& bytes, size_t at) {
  const std::string begin = bytes.substr(at, sizeof(kSlotMagic));
  return begin == std::string(kSlotMagic, sizeof(kSlotMagic)) ||
         begin == std::string(sizeof(kSlotMagic), kErased);
}

// Returns the reason why the runtime or the host rejects a blob.
std::string CheckBlob(const std::string& blob) {
  const std::vector<uint32_t> words = CopyAligned(blob);
  const auto size = static_cast<uint32_t>(blob.size());
  rg_camera camera;
  rg_blob opened;
  rg_status status = rg_camera_open(&camera, words.data(), size);
  if (status == RG_OK) status = rg_blob_open(words.data(), size, &opened);
  return status == RG_OK ? "" : rg_status_text(status);
}

BlobSlot ReadSlot(const std::string& bytes) {
  BlobSlot slot = {};
  slot.is_erased = bytes.find_first_not_of(kErased) == std::string::npos;
  const std::vector<uint32_t> words = CopyAligned(bytes);
  rg_slot found;
  slot.is_whole =
      rg_select_slot(words.data(), nullptr, static_cast<uint32_t>(bytes.size()),
                     &found) == RG_OK;
  if (slot.is_whole) {
    slot.sequence = found.sequence;
    slot.blob = bytes.substr(RG_SLOT_HEADER_SIZE, found.num_bytes);
    slot.fault = CheckBlob(slot.blob);
  }
  return slot;
}

// Returns the slot that the runtime would select among those that meet a
// condition.
template <typename AcceptsHeader>
std::optional<uint32_t> FindNewest(const std::array<BlobSlot, 2>& slots,
                                   AcceptsHeader accepts_header) {
  const bool first = accepts_header(slots[0]),
             second = accepts_header(slots[1]);
  if (!first && !second) return std::nullopt;
  if (!first || !second) return second ? 1 : 0;
  constexpr uint32_t kHalfSequenceRange =
      1u << 31;  // sequence numbers wrap around
  const uint32_t sequence_distance = slots[1].sequence - slots[0].sequence;
  return sequence_distance != 0 && sequence_distance < kHalfSequenceRange ? 1
                                                                          : 0;
}

std::string MakeSlotHeader(const std::string& blob, uint32_t sequence) {
  uint32_t header[RG_SLOT_HEADER_SIZE / 4];
  rg_make_slot_header(blob.data(), static_cast<uint32_t>(blob.size()), sequence,
                      header);
  return {reinterpret_cast<const char*>(header), sizeof(header)};
}

}  // namespace

uint64_t SlotSizeFor(const std::string& blob) {
  return RG_SLOT_HEADER_SIZE + blob.size();
}

bool IsSlotFile(const std::string& bytes) {
  const size_t half = bytes.size() / 2;
  if (HasHeaderAt(bytes, 0) || HasHeaderAt(bytes, half)) return true;
  return bytes.size() >= 2 * RG_SLOT_HEADER_SIZE && MayBeSlotAt(bytes, 0) &&
         MayBeSlotAt(bytes, half);
}

std::optional<uint64_t> FindMisplacedSlot(const std::string& bytes) {
  const std::string magic(kSlotMagic, sizeof(kSlotMagic));
  for (size_t at = bytes.find(magic, 1); at != std::string::npos;
       at = bytes.find(magic, at + 1))
    if (at != bytes.size() / 2 && HasHeaderAt(bytes, at)) return at;
  return std::nullopt;
}

BlobSlots ReadSlots(const std::string& bytes) {
  const size_t size = bytes.size() / 2;
  BlobSlots read = {
      {ReadSlot(bytes.substr(0, size)), ReadSlot(bytes.substr(size, size))},
      std::nullopt};
  read.newest = FindNewest(
      read.slots, [](const BlobSlot& slot) { return slot.IsUsable(); });
  return read;
}

SlotUpdate PlanSlotUpdate(const BlobSlots& slots, uint64_t slot_size,
                          const std::string& blob) {
  SlotUpdate update = {0, 1, {}};
  const auto is_whole = [](const BlobSlot& slot) { return slot.is_whole; };
  if (const auto kept =
          slots.newest ? slots.newest : FindNewest(slots.slots, is_whole)) {
    update.index = 1 - *kept;
    update.sequence = slots.slots[*kept].sequence + 1;
  }
  const uint64_t begin = update.index * slot_size;
  std::string rest = blob;
  rest.resize(slot_size - RG_SLOT_HEADER_SIZE, kErased);
  update.writes = {{begin, std::string(RG_SLOT_HEADER_SIZE, kErased)},
                   {begin + RG_SLOT_HEADER_SIZE, rest},
                   {begin, MakeSlotHeader(blob, update.sequence)}};
  return update;
}

}  // namespace raygrid
