/// A V4L2 device of the tests, with a script of what it does.
#ifndef RAYGRID_TEST_FAKE_V4L2_DEVICE_H
#define RAYGRID_TEST_FAKE_V4L2_DEVICE_H

#include <linux/videodev2.h>

#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "v4l2_device.h"

namespace raygrid {

/// The state of a device, which tests see after the source has it.
struct FakeV4l2State {
  struct Format {
    uint32_t code, width, height;  // the only size
    std::vector<uint32_t> strides, sizes;
    uint32_t colour_space = 0, quantization = 0;
  };
  // A frame that it fills a buffer with, or the errno of VIDIOC_DQBUF.
  struct Event {
    int error = 0;
    uint8_t value = 0;  // of all bytes
    uint32_t missing = 0;
    uint32_t flags = 0;
    uint32_t sequence = 0;
    std::string jpeg = {};  // instead of the value
  };
  struct Control {
    uint32_t id, type;
    std::string name;
    long long minimum, maximum, step, value;
    uint32_t flags;
    std::vector<std::string> items;
    // It is inactive while the control of this id, if any, has another value.
    uint32_t mode = 0;
    long long manual = 0;
    std::optional<long long> stored = {};  // becomes its value then
    int error = 0;                         // of setting it
    bool is_stubborn = false;              // takes values, and keeps its own
  };

  bool has_planes_apart = false;
  uint32_t capabilities = V4L2_CAP_STREAMING;
  std::vector<Format> formats;
  Format current = {};
  std::vector<Control> controls;
  v4l2_rect crop = {};             // of no width: it has none
  std::vector<std::string> heaps;  // that it has, none else
  std::string refused_heap;        // whose memory it does not take
  bool takes_dmabuf = true, has_cache_hints = false;
  int sync_error = 0;
  short error_events = 0;  // of poll(), once the events are over
  // Calls that fail: the errno, so many times.
  std::map<unsigned long, std::deque<int>> errors;
  std::deque<Event> events;

  std::mutex mutex;  // of all below
  uint32_t memory = 0, request_flags = 0;
  std::vector<std::vector<std::vector<uint8_t>>> buffers;
  std::map<int, std::vector<uint8_t>> dma_bufs;
  std::map<int, std::string> heap_of;
  int next_fd = 100;
  std::deque<uint32_t> queued;
  std::vector<std::pair<uint32_t, int32_t>> settings;  // of controls
  int num_queued = 0, num_mapped = 0, num_begun = 0, num_ended = 0;
  bool is_streaming = false;
};

class FakeV4l2Device : public V4l2Device {
 public:
  explicit FakeV4l2Device(FakeV4l2State* state) : state_(state) {}
  const std::string& path() const override { return path_; }
  int Ioctl(unsigned long request, void* argument) override;
  short Wait(int timeout_ms) override;
  uint8_t* Map(size_t size, uint32_t offset) override;
  std::vector<std::string> Heaps() const override { return state_->heaps; }
  int Allocate(const std::string& heap, size_t size) override;
  uint8_t* MapDmaBuf(int fd, size_t size) override;
  int Sync(int fd, bool begins) override;
  void Close(int fd) override;
  void Unmap(uint8_t* start, size_t size) override;

 private:
  uint32_t type() const;
  int GetFormat(v4l2_format* format);
  int SetFormat(v4l2_format* format, bool is_kept);
  int ListFormat(v4l2_fmtdesc* listed);
  int Request(v4l2_requestbuffers* request);
  int Describe(v4l2_buffer* buffer);
  int Queue(const v4l2_buffer& buffer);
  int Dequeue(v4l2_buffer* buffer);
  int QueryControl(v4l2_query_ext_ctrl* query);
  long long ValueOf(uint32_t id) const;
  void StoreBehind(uint32_t mode);
  int QueryMenu(v4l2_querymenu* item);
  int SetControl(v4l2_ext_controls* settings);
  int GetControl(v4l2_ext_controls* values);
  int GetSelection(v4l2_selection* selection);

  FakeV4l2State* const state_;
  const std::string path_ = "/dev/fake";
};

}  // namespace raygrid

#endif  // RAYGRID_TEST_FAKE_V4L2_DEVICE_H
