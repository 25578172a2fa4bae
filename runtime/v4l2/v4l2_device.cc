#include "v4l2_device.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "camera_error.h"
#include "dma_buf_sync.h"

#if __has_include(<linux/dma-heap.h>)
#include <linux/dma-heap.h>
#endif

namespace raygrid {
namespace {

// The first heap may be fragmented; the others are contiguous, which devices
// without an IOMMU need.
constexpr const char* kHeaps[] = {
    "/dev/dma_heap/system", "/dev/dma_heap/linux,cma", "/dev/dma_heap/reserved",
    "/dev/dma_heap/default_cma_region"};

class File {
 public:
  explicit File(int fd) : fd_(fd) {}
  ~File() {
    if (fd_ >= 0) close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int fd() const { return fd_; }

 private:
  const int fd_;
};

uint8_t* MapShared(int fd, size_t size, uint32_t offset) {
  void* const start = mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, offset);
  return start == MAP_FAILED ? nullptr : static_cast<uint8_t*>(start);
}

class KernelDevice : public V4l2Device {
 public:
  KernelDevice(const std::string& path, int fd) : path_(path), file_(fd) {}

  const std::string& path() const override { return path_; }

  int Ioctl(unsigned long request, void* argument) override {
    return ioctl(file_.fd(), request, argument) == 0 ? 0 : errno;
  }

  short Wait(int timeout_ms) override {
    pollfd waiting = {file_.fd(), POLLIN, 0};
    return poll(&waiting, 1, timeout_ms) > 0 ? waiting.revents : short{0};
  }

  uint8_t* Map(size_t size, uint32_t offset) override {
    return MapShared(file_.fd(), size, offset);
  }

  std::vector<std::string> Heaps() const override {
    std::vector<std::string> heaps;
    for (const char* heap : kHeaps)
      if (access(heap, R_OK) == 0) heaps.push_back(heap);
    return heaps;
  }

  int Allocate(const std::string& heap, size_t size) override {
#ifdef DMA_HEAP_IOCTL_ALLOC
    const File file(open(heap.c_str(), O_RDONLY | O_CLOEXEC));
    dma_heap_allocation_data data = {};
    data.len = size;
    data.fd_flags = O_RDWR | O_CLOEXEC;
    if (ioctl(file.fd(), DMA_HEAP_IOCTL_ALLOC, &data) == 0)
      return static_cast<int>(data.fd);
#else
    static_cast<void>(heap);
    static_cast<void>(size);
#endif
    return -1;
  }

  uint8_t* MapDmaBuf(int fd, size_t size) override {
    return MapShared(fd, size, 0);
  }
  int Sync(int fd, bool begins) override { return SyncDmaBuf(fd, begins); }
  void Close(int fd) override { close(fd); }
  void Unmap(uint8_t* start, size_t size) override { munmap(start, size); }

 private:
  const std::string path_;
  const File file_;
};

std::string Remedy(int error) {
  if (error == EACCES || error == EPERM)
    return "; add the user to the group video";
  if (error == EBUSY) return "; stop the process that uses it";
  return "; see --list";
}

}  // namespace

std::unique_ptr<V4l2Device> OpenV4l2Device(const std::string& path) {
  const int fd = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    const int error = errno;
    throw CameraError(CameraExit::kInput,
                      path + ": " + std::strerror(error) + Remedy(error));
  }
  auto device = std::make_unique<KernelDevice>(path, fd);
  struct stat status;
  v4l2_capability capability = {};
  if (fstat(fd, &status) != 0 || !S_ISCHR(status.st_mode) ||
      IoctlWithRetry(device.get(), VIDIOC_QUERYCAP, &capability) != 0)
    throw CameraError(CameraExit::kInput,
                      path + ": not a video device; see --list");
  return device;
}

int IoctlWithRetry(V4l2Device* device, unsigned long request, void* argument) {
  int status;
  do {
    status = device->Ioctl(request, argument);
  } while (status == EINTR);
  return status;
}

}  // namespace raygrid
