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
  bool is_whole;          ///< its header and its CRCs are right
  uint32_t sequence = 0;  ///< of a whole one, and its bytes
  std::string blob;
  /// Why the runtime does not open these bytes; empty if it does.
  std::string fault;

  /// Whether it holds a blob that a board opens.
  bool IsUsable() const { return is_whole && fault.empty(); }
};

/// Two slots, each half of the bytes, whose number is a multiple of 8.
struct BlobSlots {
  std::array<BlobSlot, 2> slots;
  std::optional<uint32_t> newest;  ///< usable one; nothing if neither is
};

/// Bytes that a slot must have for a blob.
uint64_t SlotSizeFor(const std::string& blob);

/// Whether bytes are two slots: one has a slot's header, or both begin as a
/// header or as erased flash does. A blob is none, whatever its name is.
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

/// The writes that bring a blob into the slot that is not the newest usable
/// one, or, if none is usable, not the newest whole one.
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
