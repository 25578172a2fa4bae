#ifndef RAYGRID_LIBCAMERA_MAPPED_BUFFERS_H
#define RAYGRID_LIBCAMERA_MAPPED_BUFFERS_H

#include <libcamera/framebuffer.h>

#include <array>
#include <memory>
#include <vector>

#include "dma_buf_sync.h"
#include "stream_format.h"

namespace raygrid {

/// The planes of libcamera's buffers, mapped into this process during the
/// object's lifetime.
class MappedBuffers {
 public:
  /// Throws CameraError if a buffer is smaller than the format's planes.
  MappedBuffers(
      const StreamFormat& format,
      const std::vector<std::unique_ptr<libcamera::FrameBuffer>>& buffers);
  ~MappedBuffers();
  MappedBuffers(const MappedBuffers&) = delete;
  MappedBuffers& operator=(const MappedBuffers&) = delete;

  /// Addresses of the planes of a buffer.
  const std::array<const uint8_t*, 3>& planes(size_t buffer) const {
    return planes_[buffer];
  }
  /// Called before and after reading a buffer; see DmaBufSync.
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
  std::vector<std::vector<int>> fds_;  // without duplicates
  DmaBufSync sync_;
};

/// Returns whether a completed buffer contains all bytes of the planes.
bool IsWhole(const StreamFormat& format,
             const libcamera::FrameMetadata& metadata);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_MAPPED_BUFFERS_H
