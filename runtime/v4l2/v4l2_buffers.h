#ifndef RAYGRID_V4L2_V4L2_BUFFERS_H
#define RAYGRID_V4L2_V4L2_BUFFERS_H

#include <linux/videodev2.h>

#include <array>
#include <string>
#include <vector>

#include "dma_buf_sync.h"
#include "v4l2_stream.h"

namespace raygrid {

/// A buffer filled by the driver.
struct V4l2Filled {
  uint32_t buffer;
  bool is_whole;     // complete, without an error
  size_t num_bytes;  // size of a JPEG
  uint32_t sequence;
  uint64_t timestamp_ns;
};

/// Memory for frames, mapped during the object's lifetime: allocated from a
/// dma-buf heap, which is cached, if the driver accepts it, else by the driver.
class V4l2Buffers {
 public:
  /// Queues all buffers to the driver. Throws CameraError if memory cannot be
  /// allocated.
  V4l2Buffers(V4l2Device* device, const V4l2Stream& stream, uint32_t number);
  ~V4l2Buffers() { Free(); }
  V4l2Buffers(const V4l2Buffers&) = delete;
  V4l2Buffers& operator=(const V4l2Buffers&) = delete;

  uint32_t number() const { return static_cast<uint32_t>(buffers_.size()); }
  /// Owner of the memory, for display.
  const std::string& memory() const { return memory_; }
  /// Addresses of the planes of a buffer.
  const std::array<const uint8_t*, 3>& planes(uint32_t buffer) const {
    return buffers_[buffer].planes;
  }

  /// Dequeues a filled buffer. Returns 0, or the errno.
  int Dequeue(V4l2Filled* filled);
  /// Queues a buffer to the driver. Returns 0, or the errno.
  int Queue(uint32_t buffer);
  /// Called before and after reading a buffer. Returns whether it is valid.
  bool BeginRead(uint32_t buffer);
  void EndRead(uint32_t buffer);

 private:
  struct Memory {
    int fd = -1;  // dma-buf from a heap
    uint8_t* start = nullptr;
    size_t size = 0;
  };
  struct Buffer {
    std::array<Memory, 3> mem_planes;
    std::array<const uint8_t*, 3> planes;
  };
  // A v4l2_buffer and the planes that it points to.
  struct Description;

  int Request(uint32_t kind, uint32_t number, uint32_t flags,
              v4l2_requestbuffers* request);
  bool AllocateFrom(const std::string& heap, uint32_t number);
  bool AllocateFromHeap(const std::string& heap);
  void AllocateDriverBuffers(uint32_t number);
  void MapDriverBuffer(uint32_t index);
  bool QueueAll();
  void FindPlanes(Buffer* buffer) const;
  bool IsWhole(const v4l2_buffer& buffer) const;
  void Free();

  V4l2Device* const device_;
  const V4l2Stream stream_;
  uint32_t kind_ = V4L2_MEMORY_MMAP;
  std::vector<Buffer> buffers_;
  std::string memory_;
  DmaBufSync sync_;
};

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_BUFFERS_H
