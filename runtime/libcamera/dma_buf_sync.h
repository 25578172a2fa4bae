#ifndef RAYGRID_LIBCAMERA_DMA_BUF_SYNC_H
#define RAYGRID_LIBCAMERA_DMA_BUF_SYNC_H

#include <atomic>
#include <functional>

namespace raygrid {

/// DMA_BUF_IOCTL_SYNC of a dma-buf that is read, or read no longer. Returns 0,
/// or the errno.
int SyncDmaBuf(int fd, bool begins);

/// Keeps a processor's caches and the memory that devices write to in step,
/// where the kernel offers to. By several threads at a time.
class DmaBufSync {
 public:
  using SyncFunction = std::function<int(int fd, bool begins)>;
  explicit DmaBufSync(SyncFunction sync = SyncDmaBuf);

  /// Around all reads of a frame. Returns whether what is read is what the
  /// device wrote.
  bool BeginRead(int fd) { return Sync(fd, true); }
  void EndRead(int fd) { Sync(fd, false); }

 private:
  bool Sync(int fd, bool begins);

  const SyncFunction sync_;
  std::atomic<bool> is_offered_{true};
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_DMA_BUF_SYNC_H
