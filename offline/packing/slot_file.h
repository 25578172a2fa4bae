#ifndef RAYGRID_PACKING_SLOT_FILE_H
#define RAYGRID_PACKING_SLOT_FILE_H

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace raygrid {

/// One of the two slots of a device's flash (formats/SPEC.md, "Slots").
struct BlobSlot {
  bool is_erased;         ///< all bytes are FFh
  bool is_valid;          ///< it has a whole blob
  uint32_t sequence = 0;  ///< of a valid one, and its blob
  std::string blob;
};

/// Two slots, each half of the bytes, whose number is a multiple of 8.
struct BlobSlots {
  std::array<BlobSlot, 2> slots;
  std::optional<uint32_t> newest;  ///< 0 or 1; nothing if neither is valid
};

/// Bytes that a slot must have for a blob.
uint64_t SlotSizeFor(const std::string& blob);

/// Whether a file begins as one slot, or has the second one in its middle.
bool IsSlotFile(const std::string& bytes);

BlobSlots ReadSlots(const std::string& bytes);

/// The place of a slot that is neither the first one nor in the middle of the
/// bytes: these are not the two slots of a device, or not all of them.
std::optional<uint64_t> FindMisplacedSlot(const std::string& bytes);

/// Bytes to be written at a place.
struct SlotWrite {
  uint64_t offset;  ///< from the first slot's first byte
  std::string bytes;
};

/// The writes that bring a blob into the slot that is not the newest.
struct SlotUpdate {
  uint32_t index, sequence;
  /// In this order. Each one must be on disk before the next one begins: then
  /// a cut at any moment leaves the newest blob that was there.
  std::vector<SlotWrite> writes;
};

/// The blob must fit: SlotSizeFor().
SlotUpdate PlanSlotUpdate(const BlobSlots& slots, uint64_t slot_size,
                          const std::string& blob);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_SLOT_FILE_H
