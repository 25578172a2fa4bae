#ifndef RAYGRID_LIBCAMERA_MAPPED_BUFFERS_H
#define RAYGRID_LIBCAMERA_MAPPED_BUFFERS_H

#include <libcamera/framebuffer.h>

#include <array>
#include <memory>
#include <vector>

#include "dma_buf_sync.h"
#include "stream_format.h"

namespace raygrid {

/// The planes of libcamera's buffers in this process's memory, each mapped once
/// for as long as this lives.
class MappedBuffers {
 public:
  /// Throws CameraError where a buffer is smaller than the format's planes.
  MappedBuffers(
      const StreamFormat& format,
      const std::vector<std::unique_ptr<libcamera::FrameBuffer>>& buffers);
  ~MappedBuffers();
  MappedBuffers(const MappedBuffers&) = delete;
  MappedBuffers& operator=(const MappedBuffers&) = delete;

  /// The first bytes of a buffer's planes.
  const std::array<const uint8_t*, 3>& planes(size_t buffer) const {
    return planes_[buffer];
  }
  /// Around all reads of a buffer, as DmaBufSync.
  bool BeginRead(size_t buffer);
  void EndRead(size_t buffer);

 private:
  struct Mapping {
    int fd;
    uint8_t* start;
    size_t size;
  };
  uint8_t* Map(int fd);
  void MapBuffer(const StreamFormat& format,
                 const libcamera::FrameBuffer& buffer);
  void Unmap();

  std::vector<Mapping> mappings_;
  std::vector<std::array<const uint8_t*, 3>> planes_;
  std::vector<std::vector<int>> fds_;  // each once
  DmaBufSync sync_;
};

/// Whether a completed buffer holds all bytes of the format's planes.
bool IsWhole(const StreamFormat& format,
             const libcamera::FrameMetadata& metadata);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_MAPPED_BUFFERS_H
