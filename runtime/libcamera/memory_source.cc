#include "memory_source.h"

#include <utility>

#include "camera_error.h"

namespace raygrid {
namespace {

constexpr uint32_t kNumBuffers = 4;  // as in cameras
constexpr std::chrono::milliseconds kBufferPatience(50);

}  // namespace

MemorySource::MemorySource(const StreamFormat& format,
                           std::vector<uint8_t> recording,
                           const MemorySourceOptions& options)
    : format_(format),
      recording_(std::move(recording)),
      options_(options),
      queue_(options.every_frame ? kNumBuffers : kNumBuffers / 2),
      free_buffers_(kNumBuffers) {
  if (recording_.empty() || recording_.size() % format.packed_size() != 0)
    throw CameraError(CameraExit::kInput,
                      "recording: " + std::to_string(recording_.size()) +
                          " bytes are not a multiple of the frame size " +
                          std::to_string(format.packed_size()) +
                          "; check --size and --format");
  for (uint32_t i = 0; i < kNumBuffers; ++i) free_buffers_.Push(i);
}

void MemorySource::Start() { thread_ = std::thread(&MemorySource::Play, this); }

std::optional<CapturedFrame> MemorySource::Next(
    std::chrono::milliseconds timeout) {
  return queue_.Pop(timeout);
}

void MemorySource::Release(const CapturedFrame& frame) {
  free_buffers_.Push(frame.buffer);
}

SourceCounts MemorySource::counts() const {
  return {arrived_, dropped_, 0, missed_};
}

void MemorySource::Stop() {
  is_stopped_ = true;
  free_buffers_.Close();
  if (thread_.joinable()) thread_.join();
}

CapturedFrame MemorySource::MakeFrame(uint64_t index, uint32_t buffer) const {
  const uint32_t size = format_.packed_size();
  const uint8_t* const start =
      recording_.data() + index % (recording_.size() / size) * size;
  const uint8_t* planes[3] = {start, start, start};
  for (int i = 1; i < format_.num_planes; ++i)
    planes[i] = planes[i - 1] +
                format_.planes[i - 1].row_bytes * format_.planes[i - 1].rows;
  CapturedFrame frame = {};
  frame.image = MakeImage(format_, planes);
  frame.buffer = buffer;
  frame.info.sequence = static_cast<uint32_t>(index);
  return frame;
}

void MemorySource::Play() {
  const std::chrono::duration<double> interval(1 / options_.frames_per_second);
  const Clock::time_point start = Clock::now();
  for (uint64_t i = 0; options_.num_frames == 0 || i < options_.num_frames;
       ++i) {
    const auto since_start =
        std::chrono::duration_cast<Clock::duration>(interval * i);
    std::this_thread::sleep_until(start + since_start);
    std::optional<uint32_t> buffer;
    do {
      if (is_stopped_) break;
      buffer = free_buffers_.Pop(options_.every_frame
                                     ? kBufferPatience
                                     : std::chrono::milliseconds(0));
    } while (!buffer && options_.every_frame);
    if (is_stopped_) break;
    if (!buffer) {
      ++missed_;
      continue;
    }
    CapturedFrame frame = MakeFrame(i, *buffer);
    frame.arrived = Clock::now();
    frame.info.timestamp_ns =
        static_cast<uint64_t>(std::chrono::nanoseconds(since_start).count());
    ++arrived_;
    if (const auto dropped = queue_.Push(frame)) {
      ++dropped_;
      free_buffers_.Push(dropped->buffer);
    }
  }
  queue_.Close();
}

}  // namespace raygrid
