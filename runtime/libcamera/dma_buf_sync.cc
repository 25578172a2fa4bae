#include "dma_buf_sync.h"

#include <linux/dma-buf.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <utility>

namespace raygrid {

int SyncDmaBuf(int fd, bool begins) {
  dma_buf_sync sync = {};
  sync.flags =
      DMA_BUF_SYNC_READ | (begins ? DMA_BUF_SYNC_START : DMA_BUF_SYNC_END);
  return ioctl(fd, DMA_BUF_IOCTL_SYNC, &sync) == 0 ? 0 : errno;
}

DmaBufSync::DmaBufSync(SyncFunction sync) : sync_(std::move(sync)) {}

bool DmaBufSync::Sync(int fd, bool begins) {
  if (!is_offered_) return true;
  int status;
  do {
    status = sync_(fd, begins);
  } while (status == EINTR || status == EAGAIN);
  // Memory without this ioctl does not need it; emulators may lack it.
  if (status == ENOTTY || status == ENOSYS) is_offered_ = false;
  return status == 0 || !is_offered_;
}

}  // namespace raygrid
