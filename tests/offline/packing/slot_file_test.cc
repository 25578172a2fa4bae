// Two slots of a device's flash, as the host writes them.

#include "packing/slot_file.h"

#include <map>

#include "packed_cameras.h"

namespace raygrid {
namespace {

constexpr uint64_t kSlotSize = 2048;

std::string PackedSmall(const std::string& name, const std::string& serial) {
  static const auto* const camera =
      new std::shared_ptr<CameraModel>(std::make_shared<CentralGeneric>(
          FittedGrid(ExampleSimulatedCamera(), 320)));
  CameraFile file = GenericFile();
  file.camera = *camera;
  file.name = name;
  file.serial = serial;
  return PackCamera(file, {}).blob;
}

// A small blob of a camera, with anything behind it.
std::string BlobOf(const std::string& serial, size_t size = 0) {
  static auto* const packed = new std::map<std::string, std::string>;
  std::string& made = (*packed)[serial];
  if (made.empty()) made = PackedSmall("front", serial);
  std::string blob = made;
  if (blob.size() < size) blob.resize(size, 'x');
  return blob;
}

// Bytes that a right slot holds and that no board opens.
std::string DamagedBlob(const std::string& serial, size_t at) {
  std::string blob = BlobOf(serial);
  blob[at] = static_cast<char>(blob[at] ^ 1);
  return blob;
}

// Writes what a program would that does not look at what it brings, into the
// slot that is not the newest whole one.
void WriteAnything(const std::string& blob, uint32_t index, uint32_t sequence,
                   std::string* flash) {
  BlobSlots slots = {};
  slots.newest = 1 - index;
  slots.slots[1 - index].sequence = sequence - 1;
  for (const SlotWrite& write : PlanSlotUpdate(slots, kSlotSize, blob).writes)
    flash->replace(write.offset, write.bytes.size(), write.bytes);
}

void Apply(const SlotWrite& write, size_t num_bytes, std::string* flash) {
  flash->replace(write.offset, num_bytes, write.bytes, 0, num_bytes);
}

void Update(const std::string& blob, std::string* flash) {
  for (const SlotWrite& write :
       PlanSlotUpdate(ReadSlots(*flash), kSlotSize, blob).writes)
    Apply(write, write.bytes.size(), flash);
}

std::string Newest(const std::string& flash) {
  const BlobSlots read = ReadSlots(flash);
  return read.newest ? read.slots[*read.newest].blob : "none";
}

TEST(SlotFile, SlotsTakeTurns) {
  std::string flash(2 * kSlotSize, '\xff');
  EXPECT_TRUE(IsSlotFile(flash));
  EXPECT_TRUE(ReadSlots(flash).slots[1].is_erased);
  for (uint32_t k = 0; k < 5; ++k) {
    const std::string blob = BlobOf(std::to_string(k));
    const SlotUpdate update = PlanSlotUpdate(ReadSlots(flash), kSlotSize, blob);
    EXPECT_EQ(update.index, k % 2);
    EXPECT_EQ(update.sequence, k + 1);
    Update(blob, &flash);
    EXPECT_EQ(Newest(flash), blob);
    EXPECT_TRUE(IsSlotFile(flash));
  }
  EXPECT_TRUE(ReadSlots(flash).slots[0].IsUsable());
  EXPECT_TRUE(ReadSlots(flash).slots[1].IsUsable());
}

TEST(SlotFile, BlobMayFillItsSlot) {
  std::string flash(2 * kSlotSize, '\xff');
  const std::string blob = BlobOf("blob", kSlotSize - SlotSizeFor(""));
  EXPECT_EQ(SlotSizeFor(blob), kSlotSize);
  Update(BlobOf("old"), &flash);
  Update(blob, &flash);
  EXPECT_EQ(Newest(flash), blob);
  EXPECT_TRUE(ReadSlots(flash).slots[0].IsUsable());
}

// Within a write, a disk may have begun anywhere: its first bytes, or its last.
TEST(SlotFile, CutAtEveryByteLeavesTheNewestBlob) {
  const std::string old = BlobOf("old"), next = BlobOf("next");
  for (const char* before : {"", "older"}) {
    std::string flash(2 * kSlotSize, '\xff');
    if (*before) Update(BlobOf(before, 1500), &flash);
    Update(old, &flash);
    const SlotUpdate update = PlanSlotUpdate(ReadSlots(flash), kSlotSize, next);
    for (const SlotWrite& write : update.writes) {
      for (size_t k = 0; k < write.bytes.size(); ++k) {
        std::string cut = flash;
        Apply(write, k, &cut);
        ASSERT_EQ(Newest(cut), old) << k;
        cut = flash;
        cut.replace(write.offset + k, std::string::npos,
                    write.bytes.substr(k) +
                        flash.substr(write.offset + write.bytes.size()));
        if (k > 0) {
          ASSERT_EQ(Newest(cut), old) << k;
        }
      }
      Apply(write, write.bytes.size(), &flash);
    }
    EXPECT_EQ(Newest(flash), next);
  }
}

// A slot that a cut left is written anew, not the whole one.
TEST(SlotFile, UpdateAfterACutKeepsTheWholeBlob) {
  std::string flash(2 * kSlotSize, '\xff');
  Update(BlobOf("old"), &flash);
  const SlotUpdate update =
      PlanSlotUpdate(ReadSlots(flash), kSlotSize, BlobOf("next"));
  Apply(update.writes[1], 200, &flash);
  const SlotUpdate again =
      PlanSlotUpdate(ReadSlots(flash), kSlotSize, BlobOf("new"));
  EXPECT_EQ(again.index, update.index);
  EXPECT_EQ(again.sequence, update.sequence);
}

// Its header and CRCs are right, so only opening it shows that it is damaged,
// or of a major version to come (bytes 8 and 9). It is written over before the
// one that opens, however new it is, and a cut leaves that one.
TEST(SlotFile, BlobThatDoesNotOpenIsWrittenOverFirst) {
  const std::string good = BlobOf("good"), next = BlobOf("next");
  std::vector<std::string> bad = {"damaged", std::string(1000, '\0'),
                                  good.substr(0, good.size() / 2)};
  for (size_t at : {0u, 8u, 9u, 12u, 100u})
    bad.push_back(DamagedBlob("bad", at));
  for (const uint32_t good_slot : {0u, 1u})
    for (const std::string& blob : bad) {
      std::string flash(2 * kSlotSize, '\xff');
      WriteAnything(good, good_slot, 7, &flash);
      WriteAnything(blob, 1 - good_slot, 8, &flash);
      const BlobSlots read = ReadSlots(flash);
      EXPECT_TRUE(read.slots[1 - good_slot].is_whole);
      EXPECT_FALSE(read.slots[1 - good_slot].fault.empty());
      EXPECT_EQ(Newest(flash), good);
      const SlotUpdate update = PlanSlotUpdate(read, kSlotSize, next);
      EXPECT_EQ(update.index, 1 - good_slot);
      for (const SlotWrite& write : update.writes) {
        Apply(write, write.bytes.size() / 2, &flash);
        EXPECT_EQ(Newest(flash), good);
        Apply(write, write.bytes.size(), &flash);
      }
      EXPECT_EQ(Newest(flash), next);
    }
}

TEST(SlotFile, TwoBlobsThatDoNotOpenTakeTurns) {
  std::string flash(2 * kSlotSize, '\xff');
  WriteAnything("one", 0, 4, &flash);
  WriteAnything("two", 1, 5, &flash);
  EXPECT_FALSE(ReadSlots(flash).newest);
  EXPECT_EQ(PlanSlotUpdate(ReadSlots(flash), kSlotSize, BlobOf("next")).index,
            0u);
}

// A camera whose name is what slots begin with, and zero bytes behind it.
TEST(SlotFile, NameOfACameraIsNoSlot) {
  const std::string blob = PackedSmall("RGSLOTS", "RGSLOTS");
  const size_t name = blob.find("RGSLOTS");
  ASSERT_NE(name, std::string::npos);
  EXPECT_FALSE(IsSlotFile(blob));
  EXPECT_FALSE(IsSlotFile(blob.substr(0, 2 * name)));
  std::string flash(2 * kSlotSize, '\xff');
  for (int turn = 0; turn < 2; ++turn) Update(blob, &flash);
  EXPECT_FALSE(FindMisplacedSlot(flash));
  EXPECT_TRUE(FindMisplacedSlot("more" + flash));
}

TEST(SlotFile, OthersAreNone) {
  EXPECT_FALSE(IsSlotFile(""));
  EXPECT_FALSE(IsSlotFile("RGSLOT"));
  EXPECT_FALSE(IsSlotFile(Packed().blob));
}

}  // namespace
}  // namespace raygrid
