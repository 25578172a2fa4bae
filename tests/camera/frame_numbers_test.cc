#include "frame_numbers.h"

#include <gtest/gtest.h>

#include <vector>

namespace raygrid {
namespace {

std::vector<uint64_t> FileNumbersOf(const std::vector<uint32_t>& sequences) {
  FrameNumbers numbers;
  std::vector<uint64_t> result;
  for (const uint32_t sequence : sequences)
    result.push_back(numbers.Next(sequence));
  return result;
}

TEST(FrameNumbers, HaveGapsWhereFramesAreMissing) {
  EXPECT_EQ(FileNumbersOf({7, 8, 9}), (std::vector<uint64_t>{0, 1, 2}));
  EXPECT_EQ(FileNumbersOf({7, 10, 11, 15}),
            (std::vector<uint64_t>{0, 3, 4, 8}));
  EXPECT_EQ(FileNumbersOf({UINT32_MAX - 1, UINT32_MAX, 1}),
            (std::vector<uint64_t>{0, 1, 3}));
}

TEST(FrameNumbers, AscendWhateverADriverCounts) {
  EXPECT_EQ(FileNumbersOf({0, 0, 0}), (std::vector<uint64_t>{0, 1, 2}));
  EXPECT_EQ(FileNumbersOf({5, 6, 0, 1, 3}),
            (std::vector<uint64_t>{0, 1, 2, 3, 5}));
}

}  // namespace
}  // namespace raygrid
