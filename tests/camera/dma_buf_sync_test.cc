#include "dma_buf_sync.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <vector>

namespace raygrid {
namespace {

// The answers of the kernel, one for each call.
struct Script {
  std::vector<int> answers;
  std::vector<bool> calls;  // whether they begin to read

  DmaBufSync MakeSync() {
    return DmaBufSync([this](int, bool begins) {
      calls.push_back(begins);
      return answers[calls.size() - 1];
    });
  }
};

TEST(DmaBufSync, CallsStandAroundReads) {
  Script script = {{0, 0}, {}};
  DmaBufSync sync = script.MakeSync();
  EXPECT_TRUE(sync.BeginRead(3));
  sync.EndRead(3);
  EXPECT_EQ(script.calls, (std::vector<bool>{true, false}));
}

TEST(DmaBufSync, InterruptedCallsAreMadeAgain) {
  Script script = {{EINTR, EAGAIN, 0}, {}};
  EXPECT_TRUE(script.MakeSync().BeginRead(3));
  EXPECT_EQ(script.calls.size(), 3u);
}

TEST(DmaBufSync, MemoryWithoutTheCallIsAskedOnce) {
  Script script = {{ENOTTY}, {}};
  DmaBufSync sync = script.MakeSync();
  EXPECT_TRUE(sync.BeginRead(3));
  sync.EndRead(3);
  EXPECT_TRUE(sync.BeginRead(3));
  EXPECT_EQ(script.calls.size(), 1u);
}

TEST(DmaBufSync, OtherErrorsMeanThatReadsAreNotToBeTrusted) {
  Script script = {{EIO, 0}, {}};
  DmaBufSync sync = script.MakeSync();
  EXPECT_FALSE(sync.BeginRead(3));
  EXPECT_TRUE(sync.BeginRead(3));
}

TEST(DmaBufSync, FilesOfOtherKindsHaveNoSuchCall) {
  const int fd = memfd_create("frame", 0);
  DmaBufSync sync;
  EXPECT_TRUE(sync.BeginRead(fd));
  sync.EndRead(fd);
  close(fd);
  // It is not asked again.
  EXPECT_TRUE(sync.BeginRead(-1));
}

}  // namespace
}  // namespace raygrid
