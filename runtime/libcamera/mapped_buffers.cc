#include "mapped_buffers.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include "camera_error.h"

namespace raygrid {
namespace {

using libcamera::FrameBuffer;

struct PlanePlace {
  int fd;
  uint64_t offset, length;
};

// The locations of the format's planes. A buffer has separate planes, or one
// that contains all, contiguously.
std::array<PlanePlace, 3> FindPlanes(const StreamFormat& format,
                                     const FrameBuffer& buffer) {
  std::array<PlanePlace, 3> places = {};
  const auto& planes = buffer.planes();
  const size_t num_planes = static_cast<size_t>(format.num_planes);
  uint64_t behind = 0;
  for (size_t i = 0; i < num_planes; ++i) {
    const size_t index = planes.size() < num_planes ? 0 : i;
    if (planes.empty())
      throw CameraError(
          CameraExit::kInput,
          "camera: delivers buffers without planes; use another --format");
    const FrameBuffer::Plane& plane = planes[index];
    const bool is_known = plane.offset != FrameBuffer::Plane::kInvalidOffset;
    places[i] = {plane.fd.get(), is_known ? plane.offset : 0, plane.length};
    if (index == i) {
      behind = 0;
    } else {
      places[i].offset += behind;
      places[i].length -= std::min<uint64_t>(behind, plane.length);
    }
    behind += uint64_t{format.planes[i].stride} * format.planes[i].rows;
  }
  return places;
}

}  // namespace

MappedBuffers::MappedBuffers(
    const StreamFormat& format,
    const std::vector<std::unique_ptr<FrameBuffer>>& buffers) {
  try {
    for (const auto& buffer : buffers) MapBuffer(format, *buffer);
  } catch (...) {
    Unmap();
    throw;
  }
}

MappedBuffers::~MappedBuffers() { Unmap(); }

void MappedBuffers::Unmap() {
  for (const Mapping& mapping : mappings_) munmap(mapping.start, mapping.size);
}

// Maps a whole dma-buf, once.
uint8_t* MappedBuffers::Map(int fd) {
  for (const Mapping& mapping : mappings_)
    if (mapping.fd == fd) return mapping.start;
  const off_t size = lseek(fd, 0, SEEK_END);
  void* const start = size <= 0 ? MAP_FAILED
                                : mmap(nullptr, static_cast<size_t>(size),
                                       PROT_READ, MAP_SHARED, fd, 0);
  if (start == MAP_FAILED)
    throw CameraError(CameraExit::kInput,
                      std::string("camera: cannot map its buffers: ") +
                          std::strerror(errno) + "; check the driver");
  mappings_.push_back({fd, static_cast<uint8_t*>(start), size_t(size)});
  return static_cast<uint8_t*>(start);
}

void MappedBuffers::MapBuffer(const StreamFormat& format,
                              const FrameBuffer& buffer) {
  const std::array<PlanePlace, 3> places = FindPlanes(format, buffer);
  std::array<const uint8_t*, 3> planes = {};
  std::vector<int> fds;
  for (int i = 0; i < format.num_planes; ++i) {
    const PlanePlace& place = places[i];
    const uint8_t* const start = Map(place.fd);
    const off_t size = lseek(place.fd, 0, SEEK_END);
    if (place.length < format.planes[i].extent() ||
        place.offset + format.planes[i].extent() > static_cast<uint64_t>(size))
      throw CameraError(CameraExit::kInput,
                        "camera: delivers buffers smaller than its frames; use "
                        "another --format");
    planes[i] = start + place.offset;
    if (std::find(fds.begin(), fds.end(), place.fd) == fds.end())
      fds.push_back(place.fd);
  }
  planes_.push_back(planes);
  fds_.push_back(fds);
}

bool MappedBuffers::BeginRead(size_t buffer) {
  bool is_good = true;
  for (const int fd : fds_[buffer]) is_good &= sync_.BeginRead(fd);
  return is_good;
}

void MappedBuffers::EndRead(size_t buffer) {
  for (const int fd : fds_[buffer]) sync_.EndRead(fd);
}

bool IsWhole(const StreamFormat& format,
             const libcamera::FrameMetadata& metadata) {
  if (metadata.status == libcamera::FrameMetadata::FrameError ||
      metadata.status == libcamera::FrameMetadata::FrameCancelled)
    return false;
  const auto planes = metadata.planes();
  if (planes.size() < static_cast<size_t>(format.num_planes)) {
    uint64_t used = 0, needed = 0;
    for (const auto& plane : planes) used += plane.bytesused;
    for (int i = 0; i < format.num_planes; ++i)
      needed += format.planes[i].extent();
    return used >= needed;
  }
  for (int i = 0; i < format.num_planes; ++i)
    if (planes[i].bytesused < format.planes[i].extent()) return false;
  return true;
}

}  // namespace raygrid
