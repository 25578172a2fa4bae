#include "v4l2_buffers.h"

#include <cerrno>

namespace raygrid {
namespace {

// The minimum for filling one while another is read.
constexpr uint32_t kMinBuffers = 2;

}  // namespace

struct V4l2Buffers::Description {
  Description(const V4l2Stream& stream, uint32_t kind, uint32_t index) {
    buffer.type = stream.buffer_type;
    buffer.memory = kind;
    buffer.index = index;
    if (!stream.is_multiplanar()) return;
    buffer.m.planes = planes;
    buffer.length = stream.num_mem_planes;
  }
  Description(const Description&) = delete;
  Description& operator=(const Description&) = delete;

  v4l2_buffer buffer = {};
  v4l2_plane planes[VIDEO_MAX_PLANES] = {};
};

V4l2Buffers::V4l2Buffers(V4l2Device* device, const V4l2Stream& stream,
                         uint32_t number)
    : device_(device), stream_(stream), sync_([device](int fd, bool begins) {
        return device->Sync(fd, begins);
      }) {
  try {
    for (const std::string& heap : device->Heaps())
      if (AllocateFrom(heap, number)) return;
    AllocateDriverBuffers(number);
  } catch (...) {
    Free();
    throw;
  }
}

int V4l2Buffers::Request(uint32_t kind, uint32_t number, uint32_t flags,
                         v4l2_requestbuffers* request) {
  *request = {};
  request->count = number;
  request->type = stream_.buffer_type;
  request->memory = kind;
#ifdef V4L2_MEMORY_FLAG_NON_COHERENT
  request->flags = static_cast<uint8_t>(flags);
#else
  static_cast<void>(flags);
#endif
  return IoctlWithRetry(device_, VIDIOC_REQBUFS, request);
}

// Whether the driver accepts memory of that heap, which only queueing the
// buffers shows.
bool V4l2Buffers::AllocateFrom(const std::string& heap, uint32_t number) {
  kind_ = V4L2_MEMORY_DMABUF;
  v4l2_requestbuffers request;
  if (Request(kind_, number, 0, &request) != 0) return false;
  buffers_.resize(request.count);
  if (request.count >= kMinBuffers && AllocateFromHeap(heap) && QueueAll()) {
    memory_ = heap + ", cached";
    return true;
  }
  Free();
  return false;
}

bool V4l2Buffers::AllocateFromHeap(const std::string& heap) {
  for (Buffer& buffer : buffers_) {
    for (uint32_t i = 0; i < stream_.num_mem_planes; ++i) {
      Memory& memory = buffer.mem_planes[i];
      memory.fd = device_->Allocate(heap, stream_.mem_plane_sizes[i]);
      if (memory.fd < 0) return false;
      memory.size = stream_.mem_plane_sizes[i];
      memory.start = device_->MapDmaBuf(memory.fd, memory.size);
      if (!memory.start) return false;
    }
    FindPlanes(&buffer);
  }
  return true;
}

void V4l2Buffers::AllocateDriverBuffers(uint32_t number) {
  kind_ = V4L2_MEMORY_MMAP;
  memory_ = "the driver's";
  v4l2_requestbuffers request;
  int status = Request(kind_, number, 0, &request);
#ifdef V4L2_MEMORY_FLAG_NON_COHERENT
  // The driver then synchronizes caches itself.
  if (status == 0 &&
      (request.capabilities & V4L2_BUF_CAP_SUPPORTS_MMAP_CACHE_HINTS)) {
    Request(kind_, 0, 0, &request);
    status = Request(kind_, number, V4L2_MEMORY_FLAG_NON_COHERENT, &request);
    memory_ += ", cached";
  }
#endif
  if (status != 0 || request.count < kMinBuffers)
    throw V4l2Error(*device_, "cannot allocate frame buffers",
                    status != 0 ? status : ENOMEM,
                    "free some memory, or use a smaller --size");
  buffers_.resize(request.count);
  for (uint32_t i = 0; i < request.count; ++i) MapDriverBuffer(i);
  if (!QueueAll())
    throw V4l2Error(*device_, "does not accept buffers; reconnect it");
}

void V4l2Buffers::MapDriverBuffer(uint32_t index) {
  Description description(stream_, kind_, index);
  const int status =
      IoctlWithRetry(device_, VIDIOC_QUERYBUF, &description.buffer);
  if (status != 0)
    throw V4l2Error(*device_, "cannot query its buffers", status,
                    "check the driver");
  for (uint32_t i = 0; i < stream_.num_mem_planes; ++i) {
    const bool is_multiplanar = stream_.is_multiplanar();
    const v4l2_plane& plane = description.planes[i];
    Memory& memory = buffers_[index].mem_planes[i];
    memory.size = is_multiplanar ? plane.length : description.buffer.length;
    if (memory.size < stream_.mem_plane_sizes[i])
      throw V4l2Error(
          *device_,
          "delivers buffers smaller than its frames; use another --format");
    memory.start =
        device_->Map(memory.size, is_multiplanar ? plane.m.mem_offset
                                                 : description.buffer.m.offset);
    if (!memory.start)
      throw V4l2Error(*device_, "cannot map its buffers; check the driver");
  }
  FindPlanes(&buffers_[index]);
}

void V4l2Buffers::FindPlanes(Buffer* buffer) const {
  for (int i = 0; i < stream_.format.num_planes; ++i)
    buffer->planes[i] = buffer->mem_planes[stream_.places[i].mem_plane].start +
                        stream_.places[i].offset;
}

bool V4l2Buffers::QueueAll() {
  for (uint32_t i = 0; i < number(); ++i)
    if (Queue(i) != 0) return false;
  return true;
}

int V4l2Buffers::Queue(uint32_t index) {
  Description description(stream_, kind_, index);
  if (kind_ == V4L2_MEMORY_DMABUF) {
    const Buffer& buffer = buffers_[index];
    for (uint32_t i = 0; i < stream_.num_mem_planes; ++i) {
      description.planes[i].m.fd = buffer.mem_planes[i].fd;
      description.planes[i].length =
          static_cast<uint32_t>(buffer.mem_planes[i].size);
    }
    if (!stream_.is_multiplanar()) {
      description.buffer.m.fd = buffer.mem_planes[0].fd;
      description.buffer.length = description.planes[0].length;
    }
  }
  return IoctlWithRetry(device_, VIDIOC_QBUF, &description.buffer);
}

int V4l2Buffers::Dequeue(V4l2Filled* filled) {
  Description description(stream_, kind_, 0);
  const v4l2_buffer& buffer = description.buffer;
  const int status = IoctlWithRetry(device_, VIDIOC_DQBUF, &description.buffer);
  if (status != 0) return status;
  if (buffer.index >= number()) return EIO;
  filled->buffer = buffer.index;
  filled->is_whole = IsWhole(buffer);
  filled->num_bytes = stream_.is_multiplanar() ? buffer.m.planes[0].bytesused
                                               : buffer.bytesused;
  filled->sequence = buffer.sequence;
  filled->timestamp_ns =
      static_cast<uint64_t>(buffer.timestamp.tv_sec) * 1000000000u +
      static_cast<uint64_t>(buffer.timestamp.tv_usec) * 1000u;
  return 0;
}

bool V4l2Buffers::IsWhole(const v4l2_buffer& buffer) const {
  if (buffer.flags & V4L2_BUF_FLAG_ERROR) return false;
  for (int i = 0; i < stream_.format.num_planes; ++i) {
    const V4l2Stream::Place& place = stream_.places[i];
    uint32_t used = buffer.bytesused;
    if (stream_.is_multiplanar()) {
      const v4l2_plane& plane = buffer.m.planes[place.mem_plane];
      // Frames with an offset in their buffers are not supported.
      if (plane.data_offset != 0) return false;
      used = plane.bytesused;
    }
    const uint32_t needed =
        stream_.is_jpeg ? 1 : place.offset + stream_.format.planes[i].extent();
    if (used < needed ||
        used > buffers_[buffer.index].mem_planes[place.mem_plane].size)
      return false;
  }
  return true;
}

bool V4l2Buffers::BeginRead(uint32_t buffer) {
  if (kind_ != V4L2_MEMORY_DMABUF) return true;
  bool is_good = true;
  for (uint32_t i = 0; i < stream_.num_mem_planes; ++i)
    is_good &= sync_.BeginRead(buffers_[buffer].mem_planes[i].fd);
  return is_good;
}

void V4l2Buffers::EndRead(uint32_t buffer) {
  if (kind_ != V4L2_MEMORY_DMABUF) return;
  for (uint32_t i = 0; i < stream_.num_mem_planes; ++i)
    sync_.EndRead(buffers_[buffer].mem_planes[i].fd);
}

void V4l2Buffers::Free() {
  // Takes back the buffers from the driver.
  int type = static_cast<int>(stream_.buffer_type);
  IoctlWithRetry(device_, VIDIOC_STREAMOFF, &type);
  for (Buffer& buffer : buffers_) {
    for (Memory& memory : buffer.mem_planes) {
      if (memory.start) device_->Unmap(memory.start, memory.size);
      if (memory.fd >= 0) device_->Close(memory.fd);
    }
  }
  buffers_.clear();
  v4l2_requestbuffers request;
  Request(kind_, 0, 0, &request);
}

}  // namespace raygrid
