#include "fake_v4l2_device.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

namespace raygrid {

uint32_t FakeV4l2Device::type() const {
  return state_->has_planes_apart ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE
                                  : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

int FakeV4l2Device::Ioctl(unsigned long request, void* argument) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  auto& errors = state_->errors[request];
  if (!errors.empty()) {
    const int error = errors.front();
    errors.pop_front();
    if (error != 0) return error;
  }
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto* const capability = static_cast<v4l2_capability*>(argument);
      capability->capabilities =
          state_->capabilities |
          (state_->has_planes_apart ? V4L2_CAP_VIDEO_CAPTURE_MPLANE
                                    : V4L2_CAP_VIDEO_CAPTURE);
      std::strcpy(reinterpret_cast<char*>(capability->card), "Fake");
      return 0;
    }
    case VIDIOC_G_FMT:
      return GetFormat(static_cast<v4l2_format*>(argument));
    case VIDIOC_TRY_FMT:
      return SetFormat(static_cast<v4l2_format*>(argument), false);
    case VIDIOC_S_FMT:
      return SetFormat(static_cast<v4l2_format*>(argument), true);
    case VIDIOC_ENUM_FMT:
      return ListFormat(static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_REQBUFS:
      return Request(static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return Describe(static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return Queue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return Dequeue(static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      state_->is_streaming = true;
      return 0;
    case VIDIOC_STREAMOFF:
      state_->is_streaming = false;
      state_->queued.clear();
      return 0;
    case VIDIOC_QUERY_EXT_CTRL:
      return QueryControl(static_cast<v4l2_query_ext_ctrl*>(argument));
    case VIDIOC_QUERYMENU:
      return QueryMenu(static_cast<v4l2_querymenu*>(argument));
    case VIDIOC_S_EXT_CTRLS:
      return SetControl(static_cast<v4l2_ext_controls*>(argument));
    case VIDIOC_G_EXT_CTRLS:
      return GetControl(static_cast<v4l2_ext_controls*>(argument));
    case VIDIOC_G_SELECTION:
      return GetSelection(static_cast<v4l2_selection*>(argument));
    default:
      return ENOTTY;
  }
}

int FakeV4l2Device::GetFormat(v4l2_format* format) {
  return SetFormat(format, false);
}

// The format asked for, or the first one; it has one size.
int FakeV4l2Device::SetFormat(v4l2_format* format, bool is_kept) {
  if (format->type != type()) return EINVAL;
  FakeV4l2State::Format chosen = state_->formats[0];
  const uint32_t code = state_->has_planes_apart
                            ? format->fmt.pix_mp.pixelformat
                            : format->fmt.pix.pixelformat;
  for (const auto& known : state_->formats)
    if (known.code == code) chosen = known;
  if (is_kept) state_->current = chosen;
  if (state_->has_planes_apart) {
    v4l2_pix_format_mplane& pix = format->fmt.pix_mp;
    pix.pixelformat = chosen.code;
    pix.width = chosen.width;
    pix.height = chosen.height;
    pix.field = V4L2_FIELD_NONE;
    pix.num_planes = static_cast<uint8_t>(chosen.sizes.size());
    pix.colorspace = chosen.colour_space;
    pix.quantization = static_cast<uint8_t>(chosen.quantization);
    for (size_t i = 0; i < chosen.sizes.size(); ++i) {
      pix.plane_fmt[i].bytesperline = chosen.strides[i];
      pix.plane_fmt[i].sizeimage = chosen.sizes[i];
    }
    return 0;
  }
  v4l2_pix_format& pix = format->fmt.pix;
  pix.pixelformat = chosen.code;
  pix.width = chosen.width;
  pix.height = chosen.height;
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = chosen.strides[0];
  pix.sizeimage = chosen.sizes[0];
  pix.colorspace = chosen.colour_space;
  pix.quantization = chosen.quantization;
  return 0;
}

int FakeV4l2Device::ListFormat(v4l2_fmtdesc* listed) {
  if (listed->index >= state_->formats.size()) return EINVAL;
  listed->pixelformat = state_->formats[listed->index].code;
  return 0;
}

int FakeV4l2Device::Request(v4l2_requestbuffers* request) {
  if (request->memory == V4L2_MEMORY_DMABUF && !state_->takes_dmabuf)
    return EINVAL;
  state_->memory = request->memory;
  state_->request_flags = request->flags;
  request->capabilities =
      state_->has_cache_hints ? V4L2_BUF_CAP_SUPPORTS_MMAP_CACHE_HINTS : 0;
  state_->queued.clear();
  state_->buffers.clear();
  for (uint32_t i = 0; i < request->count; ++i) {
    state_->buffers.emplace_back();
    for (const uint32_t size : state_->current.sizes)
      state_->buffers.back().emplace_back(size);
  }
  return 0;
}

// An offset is the buffer's number and the memory's.
int FakeV4l2Device::Describe(v4l2_buffer* buffer) {
  const auto& memories = state_->buffers[buffer->index];
  if (!state_->has_planes_apart) {
    buffer->length = static_cast<uint32_t>(memories[0].size());
    buffer->m.offset = buffer->index * 4096 * 16;
    return 0;
  }
  for (uint32_t i = 0; i < memories.size(); ++i) {
    buffer->m.planes[i].length = static_cast<uint32_t>(memories[i].size());
    buffer->m.planes[i].m.mem_offset = (buffer->index * 16 + i) * 4096;
  }
  return 0;
}

int FakeV4l2Device::Queue(const v4l2_buffer& buffer) {
  if (buffer.memory == V4L2_MEMORY_DMABUF) {
    auto& memories = state_->buffers[buffer.index];
    for (size_t i = 0; i < memories.size(); ++i) {
      const int fd =
          state_->has_planes_apart ? buffer.m.planes[i].m.fd : buffer.m.fd;
      const auto found = state_->dma_bufs.find(fd);
      if (found == state_->dma_bufs.end()) return EINVAL;
      if (state_->heap_of[fd] == state_->refused_heap) return EFAULT;
      if (found->second.size() > memories[i].size()) return EFAULT;
    }
  }
  state_->queued.push_back(buffer.index);
  ++state_->num_queued;
  return 0;
}

int FakeV4l2Device::Dequeue(v4l2_buffer* buffer) {
  if (!state_->is_streaming || state_->events.empty()) return EAGAIN;
  const FakeV4l2State::Event event = state_->events.front();
  if (event.error == 0 && state_->queued.empty()) return EAGAIN;
  state_->events.pop_front();
  if (event.error != 0) return event.error;
  buffer->index = state_->queued.front();
  state_->queued.pop_front();
  buffer->flags = event.flags;
  buffer->sequence = event.sequence;
  buffer->timestamp.tv_sec = 1;
  buffer->timestamp.tv_usec = event.sequence;
  auto& memories = state_->buffers[buffer->index];
  for (size_t i = 0; i < memories.size(); ++i) {
    std::fill(memories[i].begin(), memories[i].end(), event.value);
    std::copy(event.jpeg.begin(), event.jpeg.end(), memories[i].begin());
    const size_t filled =
        event.jpeg.empty() ? memories[i].size() : event.jpeg.size();
    const uint32_t used = static_cast<uint32_t>(filled) - event.missing;
    if (state_->has_planes_apart)
      buffer->m.planes[i].bytesused = used;
    else
      buffer->bytesused = used;
  }
  if (state_->memory != V4L2_MEMORY_DMABUF) return 0;
  // The buffers of the first file descriptors, in their order.
  int fd = state_->dma_bufs.begin()->first +
           static_cast<int>(buffer->index * memories.size());
  for (const auto& memory : memories)
    std::copy(memory.begin(), memory.end(), state_->dma_bufs[fd++].begin());
  return 0;
}

int FakeV4l2Device::QueryControl(v4l2_query_ext_ctrl* query) {
  const uint32_t last = query->id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
  const bool is_next = last != query->id;
  for (const FakeV4l2State::Control& control : state_->controls) {
    if (is_next ? control.id <= last : control.id != last) continue;
    *query = {};
    query->id = control.id;
    query->type = control.type;
    std::strncpy(query->name, control.name.c_str(), sizeof(query->name) - 1);
    query->minimum = control.minimum;
    query->maximum = control.maximum;
    query->step = static_cast<uint64_t>(control.step);
    query->flags = control.flags;
    if (control.mode != 0 && ValueOf(control.mode) != control.manual)
      query->flags |= V4L2_CTRL_FLAG_INACTIVE;
    return 0;
  }
  return EINVAL;
}

long long FakeV4l2Device::ValueOf(uint32_t id) const {
  for (const FakeV4l2State::Control& control : state_->controls)
    if (control.id == id) return control.value;
  return 0;
}

void FakeV4l2Device::StoreBehind(uint32_t mode) {
  for (FakeV4l2State::Control& control : state_->controls)
    if (control.mode == mode && control.stored &&
        ValueOf(mode) == control.manual)
      control.value = *control.stored;
}

int FakeV4l2Device::QueryMenu(v4l2_querymenu* item) {
  for (const FakeV4l2State::Control& control : state_->controls) {
    if (control.id != item->id) continue;
    if (item->index >= control.items.size() ||
        control.items[item->index].empty())
      return EINVAL;
    std::strcpy(reinterpret_cast<char*>(item->name),
                control.items[item->index].c_str());
    return 0;
  }
  return EINVAL;
}

// A control of value 1 wakes the one behind it.
int FakeV4l2Device::SetControl(v4l2_ext_controls* settings) {
  v4l2_ext_control& setting = settings->controls[0];
  for (size_t i = 0; i < state_->controls.size(); ++i) {
    FakeV4l2State::Control& control = state_->controls[i];
    if (control.id != setting.id) continue;
    // The kernel's structure is packed: no reference to it.
    state_->settings.push_back({uint32_t{setting.id}, int32_t{setting.value}});
    if (control.error != 0) return control.error;
    if (control.is_stubborn) return 0;
    control.value = setting.value;
    StoreBehind(control.id);
    if (i + 1 < state_->controls.size() && setting.value == 1)
      state_->controls[i + 1].flags = 0;
    return 0;
  }
  return EINVAL;
}

int FakeV4l2Device::GetControl(v4l2_ext_controls* values) {
  v4l2_ext_control& value = values->controls[0];
  for (const FakeV4l2State::Control& control : state_->controls) {
    if (control.id != value.id) continue;
    value.value = static_cast<int32_t>(control.value);
    return 0;
  }
  return EINVAL;
}

int FakeV4l2Device::GetSelection(v4l2_selection* selection) {
  if (state_->crop.width == 0) return ENOTTY;
  if (selection->type != V4L2_BUF_TYPE_VIDEO_CAPTURE ||
      selection->target != V4L2_SEL_TGT_CROP)
    return EINVAL;
  selection->r = state_->crop;
  return 0;
}

short FakeV4l2Device::Wait(int timeout_ms) {
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    if (!state_->events.empty() &&
        (state_->events.front().error != 0 || !state_->queued.empty()))
      return POLLIN;
    if (state_->events.empty() && state_->error_events != 0)
      return state_->error_events;
  }
  std::this_thread::sleep_for(
      std::chrono::milliseconds(std::min(timeout_ms, 2)));
  return 0;
}

uint8_t* FakeV4l2Device::Map(size_t, uint32_t offset) {
  ++state_->num_mapped;
  const uint32_t number = offset / 4096;
  return state_->buffers[number / 16][number % 16].data();
}

int FakeV4l2Device::Allocate(const std::string& heap, size_t size) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->dma_bufs[state_->next_fd].resize(size);
  state_->heap_of[state_->next_fd] = heap;
  return state_->next_fd++;
}

uint8_t* FakeV4l2Device::MapDmaBuf(int fd, size_t) {
  ++state_->num_mapped;
  return state_->dma_bufs[fd].data();
}

int FakeV4l2Device::Sync(int fd, bool begins) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (state_->dma_bufs.count(fd) == 0) return EBADF;
  ++(begins ? state_->num_begun : state_->num_ended);
  return state_->sync_error;
}

void FakeV4l2Device::Close(int fd) { state_->dma_bufs.erase(fd); }

void FakeV4l2Device::Unmap(uint8_t*, size_t) { --state_->num_mapped; }

}  // namespace raygrid
