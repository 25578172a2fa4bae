// Two slots of a device's flash, as the host writes them.

#include "packing/slot_file.h"

#include "packed_cameras.h"

namespace raygrid {
namespace {

constexpr uint64_t kSlotSize = 1024;

std::string TextBlob(const std::string& word, size_t size) {
  std::string blob;
  while (blob.size() < size) blob += word;
  return blob.substr(0, size);
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
  EXPECT_FALSE(IsSlotFile(flash));
  EXPECT_TRUE(ReadSlots(flash).slots[1].is_erased);
  for (uint32_t k = 0; k < 5; ++k) {
    const std::string blob = TextBlob(std::to_string(k), 100 + k);
    const SlotUpdate update = PlanSlotUpdate(ReadSlots(flash), kSlotSize, blob);
    EXPECT_EQ(update.index, k % 2);
    EXPECT_EQ(update.sequence, k + 1);
    Update(blob, &flash);
    EXPECT_EQ(Newest(flash), blob);
    EXPECT_TRUE(IsSlotFile(flash));
  }
  EXPECT_TRUE(ReadSlots(flash).slots[0].is_valid);
  EXPECT_TRUE(ReadSlots(flash).slots[1].is_valid);
}

TEST(SlotFile, BlobMayFillItsSlot) {
  std::string flash(2 * kSlotSize, '\xff');
  const std::string blob = TextBlob("blob", kSlotSize - SlotSizeFor(""));
  EXPECT_EQ(SlotSizeFor(blob), kSlotSize);
  Update(TextBlob("old", 9), &flash);
  Update(blob, &flash);
  EXPECT_EQ(Newest(flash), blob);
  EXPECT_TRUE(ReadSlots(flash).slots[0].is_valid);
}

// Within a write, a disk may have begun anywhere: its first bytes, or its last.
TEST(SlotFile, CutAtEveryByteLeavesTheNewestBlob) {
  const std::string old = TextBlob("old", 300), next = TextBlob("next", 500);
  for (const char* before : {"", "older"}) {
    std::string flash(2 * kSlotSize, '\xff');
    if (*before) Update(TextBlob(before, 700), &flash);
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
  Update("old ", &flash);
  const SlotUpdate update =
      PlanSlotUpdate(ReadSlots(flash), kSlotSize, TextBlob("next", 500));
  Apply(update.writes[1], 200, &flash);
  const SlotUpdate again = PlanSlotUpdate(ReadSlots(flash), kSlotSize, "new ");
  EXPECT_EQ(again.index, update.index);
  EXPECT_EQ(again.sequence, update.sequence);
}

TEST(SlotFile, OthersAreNone) {
  EXPECT_FALSE(IsSlotFile(""));
  EXPECT_FALSE(IsSlotFile("RGSLOT"));
  EXPECT_FALSE(IsSlotFile(Packed().blob));
}

}  // namespace
}  // namespace raygrid
