#include "packing/slot_file.h"

#include <algorithm>
#include <cstring>

#include "blob_layout.h"
#include "raygrid.h"

namespace raygrid {
namespace {

constexpr char kErased = '\xff';
constexpr char kSlotMagic[] = "RGSLOTS";  // with its zero

std::vector<uint32_t> AlignedWords(const std::string& bytes) {
  std::vector<uint32_t> words((bytes.size() + 3) / 4);
  std::memcpy(words.data(), bytes.data(), bytes.size());
  return words;
}

BlobSlot ReadSlot(const std::string& bytes) {
  BlobSlot slot = {};
  slot.is_erased = bytes.find_first_not_of(kErased) == std::string::npos;
  const std::vector<uint32_t> words = AlignedWords(bytes);
  rg_slot found;
  slot.is_valid =
      rg_choose_slot(words.data(), nullptr, static_cast<uint32_t>(bytes.size()),
                     &found) == RG_OK;
  if (slot.is_valid) {
    slot.sequence = found.sequence;
    slot.blob = bytes.substr(RG_SLOT_HEADER_SIZE, found.num_bytes);
  }
  return slot;
}

std::string HeaderOf(const std::string& blob, uint32_t sequence) {
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
  const size_t size = sizeof(kSlotMagic);
  return bytes.compare(0, size, kSlotMagic, size) == 0 ||
         bytes.compare(bytes.size() / 2, size, kSlotMagic, size) == 0;
}

std::optional<uint64_t> FindMisplacedSlot(const std::string& bytes) {
  const std::string magic(kSlotMagic, sizeof(kSlotMagic));
  for (size_t at = bytes.find(magic, 1); at != std::string::npos;
       at = bytes.find(magic, at + 1))
    if (at != bytes.size() / 2) return at;
  return std::nullopt;
}

BlobSlots ReadSlots(const std::string& bytes) {
  const size_t size = bytes.size() / 2;
  BlobSlots read = {
      {ReadSlot(bytes.substr(0, size)), ReadSlot(bytes.substr(size, size))},
      std::nullopt};
  const std::vector<uint32_t> words = AlignedWords(bytes);
  rg_slot newest;
  if (rg_choose_slot(words.data(), words.data() + size / 4,
                     static_cast<uint32_t>(size), &newest) == RG_OK)
    read.newest = newest.index;
  return read;
}

SlotUpdate PlanSlotUpdate(const BlobSlots& slots, uint64_t slot_size,
                          const std::string& blob) {
  SlotUpdate update = {0, 1, {}};
  if (slots.newest) {
    update.index = 1 - *slots.newest;
    update.sequence = slots.slots[*slots.newest].sequence + 1;
  }
  const uint64_t begin = update.index * slot_size;
  std::string rest = blob;
  rest.resize(slot_size - RG_SLOT_HEADER_SIZE, kErased);
  update.writes = {{begin, std::string(RG_SLOT_HEADER_SIZE, kErased)},
                   {begin + RG_SLOT_HEADER_SIZE, rest},
                   {begin, HeaderOf(blob, update.sequence)}};
  return update;
}

}  // namespace raygrid
