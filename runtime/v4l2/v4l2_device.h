/// The kernel interface of a video device. Tests substitute a simulated one.
#ifndef RAYGRID_V4L2_V4L2_DEVICE_H
#define RAYGRID_V4L2_V4L2_DEVICE_H

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace raygrid {

class V4l2Device {
 public:
  virtual ~V4l2Device() = default;
  /// Path of the device, for messages.
  virtual const std::string& path() const = 0;
  /// Calls ioctl() on the device. Returns 0, or the errno.
  virtual int Ioctl(unsigned long request, void* argument) = 0;
  /// Polls for frames and returns revents; 0 on timeout.
  virtual short Wait(int timeout_ms) = 0;
  /// Maps the driver's memory for reading; NULL on failure.
  virtual uint8_t* Map(size_t size, uint32_t offset) = 0;

  /// Paths of the heaps for allocating dma-bufs, the best first.
  virtual std::vector<std::string> Heaps() const = 0;
  /// Allocates a dma-buf from a heap and returns its descriptor; -1 on failure.
  virtual int Allocate(const std::string& heap, size_t size) = 0;
  virtual uint8_t* MapDmaBuf(int fd, size_t size) = 0;
  /// Calls SyncDmaBuf().
  virtual int Sync(int fd, bool begins) = 0;
  virtual void Close(int fd) = 0;

  /// Unmaps memory of either kind.
  virtual void Unmap(uint8_t* start, size_t size) = 0;
};

/// Throws CameraError if the path cannot be opened, or is not a video device.
std::unique_ptr<V4l2Device> OpenV4l2Device(const std::string& path);

/// Calls Ask(), again if a signal interrupts it.
int IoctlWithRetry(V4l2Device* device, unsigned long request, void* argument);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_DEVICE_H
