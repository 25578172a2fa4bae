#ifndef RAYGRID_LIBCAMERA_DMA_BUF_SYNC_H
#define RAYGRID_LIBCAMERA_DMA_BUF_SYNC_H

#include <atomic>
#include <functional>

namespace raygrid {

/// Calls DMA_BUF_IOCTL_SYNC before or after reading a dma-buf. Returns 0, or
/// the errno.
int SyncDmaBuf(int fd, bool begins);

/// Synchronizes the processor's caches with memory written by devices, if the
/// kernel supports it. Thread-safe.
class DmaBufSync {
 public:
  using SyncFunction = std::function<int(int fd, bool begins)>;
  explicit DmaBufSync(SyncFunction sync = SyncDmaBuf);

  /// Called before and after reading a frame. Returns whether the data read is
  /// coherent with the device's.
  bool BeginRead(int fd) { return Sync(fd, true); }
  void EndRead(int fd) { Sync(fd, false); }

 private:
  bool Sync(int fd, bool begins);

  const SyncFunction sync_;
  std::atomic<bool> is_offered_{true};
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_DMA_BUF_SYNC_H
