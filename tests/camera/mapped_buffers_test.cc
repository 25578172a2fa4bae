#include "mapped_buffers.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "camera_error.h"

namespace raygrid {
namespace {

using libcamera::FrameBuffer;
using libcamera::SharedFD;

constexpr size_t kSize = 4096 * 4;

// Memory that holds its own offsets, as a dma-buf.
SharedFD MakeMemory() {
  const int fd = memfd_create("frame", 0);
  for (size_t i = 0; i < kSize; i += 2) {
    const uint16_t value = static_cast<uint16_t>(i);
    EXPECT_EQ(pwrite(fd, &value, 2, static_cast<off_t>(i)), 2);
  }
  SharedFD shared(fd);
  close(fd);
  return shared;
}

unsigned OffsetAt(const uint8_t* place) {
  return place[0] | static_cast<unsigned>(place[1]) << 8;
}

FrameBuffer::Plane MakePlane(const SharedFD& fd, unsigned offset,
                             unsigned length) {
  FrameBuffer::Plane plane;
  plane.fd = fd;
  plane.offset = offset;
  plane.length = length;
  return plane;
}

std::vector<std::unique_ptr<FrameBuffer>> MakeBuffers(
    const std::vector<FrameBuffer::Plane>& planes) {
  std::vector<std::unique_ptr<FrameBuffer>> buffers;
  buffers.push_back(std::make_unique<FrameBuffer>(planes));
  return buffers;
}

StreamFormat Nv12() {
  return MakeStreamFormat(*FindPixelFormat("NV12"), 64, 48, 80);
}

TEST(MappedBuffers, OffsetsOfPlanesInOneMemoryAreHonoured) {
  const SharedFD memory = MakeMemory();
  const MappedBuffers mapped(Nv12(),
                             MakeBuffers({MakePlane(memory, 100, 80 * 48),
                                          MakePlane(memory, 6000, 80 * 24)}));
  EXPECT_EQ(OffsetAt(mapped.planes(0)[0]), 100u);
  EXPECT_EQ(OffsetAt(mapped.planes(0)[1]), 6000u);
}

TEST(MappedBuffers, PlanesMayLieInMemoriesOfTheirOwn) {
  const MappedBuffers mapped(
      Nv12(), MakeBuffers({MakePlane(MakeMemory(), 0, 80 * 48),
                           MakePlane(MakeMemory(), 8, 80 * 24)}));
  EXPECT_EQ(OffsetAt(mapped.planes(0)[0]), 0u);
  EXPECT_EQ(OffsetAt(mapped.planes(0)[1]), 8u);
}

TEST(MappedBuffers, OnePlaneHoldsAllOneBehindTheOther) {
  const MappedBuffers mapped(
      MakeStreamFormat(*FindPixelFormat("YUV420"), 64, 48, 80),
      MakeBuffers({MakePlane(MakeMemory(), 16, 80 * 72)}));
  EXPECT_EQ(OffsetAt(mapped.planes(0)[0]), 16u);
  EXPECT_EQ(OffsetAt(mapped.planes(0)[1]), 16u + 80 * 48);
  EXPECT_EQ(OffsetAt(mapped.planes(0)[2]), 16u + 80 * 48 + 40 * 24);
}

TEST(MappedBuffers, BuffersSmallerThanTheFrameAreRefused) {
  const SharedFD memory = MakeMemory();
  for (const std::vector<FrameBuffer::Plane>& planes :
       std::vector<std::vector<FrameBuffer::Plane>>{
           {MakePlane(memory, 0, 80 * 47), MakePlane(memory, 6000, 80 * 24)},
           {MakePlane(memory, 0, 80 * 48), MakePlane(memory, kSize - 8, 1920)},
           {MakePlane(memory, 0, 80 * 60)},
           {MakePlane(SharedFD(), 0, 80 * 72)},
           {}})
    EXPECT_THROW(MappedBuffers(Nv12(), MakeBuffers(planes)), CameraError);
}

}  // namespace
}  // namespace raygrid
