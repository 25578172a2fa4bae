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
  bool is_whole;          ///< header and CRCs are correct
  uint32_t sequence = 0;  ///< sequence and contents are set if whole
  std::string blob;
  /// Why the runtime rejects the contents; empty if it opens them.
  std::string fault;

  /// Whether it contains a blob that a device can open.
  bool IsUsable() const { return is_whole && fault.empty(); }
};

/// Two slots of equal size; the total is a multiple of 8 bytes.
struct BlobSlots {
  std::array<BlobSlot, 2> slots;
  std::optional<uint32_t> newest;  ///< newest usable slot, if any
};

/// Returns the slot size in bytes that a blob requires.
uint64_t SlotSizeFor(const std::string& blob);

/// Whether bytes are two slots: one has a slot header, or both begin with a
/// header or erased flash. False for a blob, regardless of its name.
bool IsSlotFile(const std::string& bytes);

BlobSlots ReadSlots(const std::string& bytes);

/// Returns the offset of a slot that is neither at the start nor at half of the
/// bytes: they are incomplete, or not the two slots of a device.
std::optional<uint64_t> FindMisplacedSlot(const std::string& bytes);

/// Bytes to be written at an offset.
struct SlotWrite {
  uint64_t offset;  ///< from the start of the first slot
  std::string bytes;
};

/// Writes that store a blob in the slot other than the newest usable one, or,
/// without any, other than the newest whole one.
struct SlotUpdate {
  uint32_t index, sequence;
  /// The writes, in order. Each must be on disk before the next one starts, so
  /// that the newest blob survives a power loss at any time.
  std::vector<SlotWrite> writes;
};

/// Plans an update. The blob must fit: SlotSizeFor().
SlotUpdate PlanSlotUpdate(const BlobSlots& slots, uint64_t slot_size,
                          const std::string& blob);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_SLOT_FILE_H
