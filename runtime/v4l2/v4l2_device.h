/// The kernel's part in a video device. Tests put a device of their own in its
/// place.
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
  /// For messages.
  virtual const std::string& path() const = 0;
  /// An ioctl() of the device. Returns 0, or the errno.
  virtual int Ask(unsigned long request, void* argument) = 0;
  /// The revents of poll() for frames; 0 where nothing happens in that time.
  virtual short Wait(int timeout_ms) = 0;
  /// The driver's memory, to be read; NULL where it cannot be mapped.
  virtual uint8_t* Map(size_t size, uint32_t offset) = 0;

  /// Paths of the heaps that dma-bufs are allocated from, the best first.
  virtual std::vector<std::string> Heaps() const = 0;
  /// A dma-buf of a heap; -1 where there is none.
  virtual int Allocate(const std::string& heap, size_t size) = 0;
  virtual uint8_t* MapDmaBuf(int fd, size_t size) = 0;
  /// SyncDmaBuf().
  virtual int Sync(int fd, bool begins) = 0;
  virtual void Close(int fd) = 0;

  /// For memory of both kinds.
  virtual void Unmap(uint8_t* start, size_t size) = 0;
};

/// Throws CameraError where it cannot be opened, or is no video device.
std::unique_ptr<V4l2Device> OpenV4l2Device(const std::string& path);

/// Ask(), again where a signal interrupts it.
int AskAgain(V4l2Device* device, unsigned long request, void* argument);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_DEVICE_H
