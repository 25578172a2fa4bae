#include "pipe_source.h"

#include <utility>

#include "camera_error.h"

namespace raygrid {
namespace {

// One frame is undistorted and one is read; the others wait.
constexpr uint32_t kNumPipeBuffers = 4;
constexpr std::chrono::milliseconds kPipePatience(50);

}  // namespace

PipeSource::PipeSource(int fd, const PipeOptions& options,
                       std::function<bool()> is_interrupted)
    : is_interrupted_(std::move(is_interrupted)),
      deadline_(Clock::now() +
                std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(options.timeout_s))),
      stream_(fd, [this] { return MustStop(); }),
      reader_(MakeFrameReader(&stream_, options.format, options.width,
                              options.height)),
      buffers_(kNumPipeBuffers),
      queue_(options.every_frame ? kNumPipeBuffers : kNumPipeBuffers / 2),
      free_(kNumPipeBuffers) {
  deadline_.reset();
  for (uint32_t i = 0; i < kNumPipeBuffers; ++i) {
    buffers_[i].resize(format().packed_size());
    free_.Push(i);
  }
}

void PipeSource::Start() { thread_ = std::thread(&PipeSource::Run, this); }

std::optional<CapturedFrame> PipeSource::Next(
    std::chrono::milliseconds timeout) {
  return queue_.Pop(timeout);
}

void PipeSource::Release(const CapturedFrame& frame) {
  free_.Push(frame.buffer);
}

std::string PipeSource::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return fault_;
}

SourceCounts PipeSource::counts() const {
  return {arrived_, dropped_, damaged_, 0};
}

void PipeSource::Stop() {
  is_stopped_ = true;
  if (thread_.joinable()) thread_.join();
}

bool PipeSource::MustStop() const {
  return is_stopped_ || is_interrupted_() ||
         (deadline_ && Clock::now() > *deadline_);
}

void PipeSource::Run() {
  try {
    ReadFrames();
  } catch (const CameraError& error) {
    Fail(error.what());
  }
  queue_.Close();
}

void PipeSource::ReadFrames() {
  while (!MustStop()) {
    const std::optional<uint32_t> buffer = free_.Pop(kPipePatience);
    if (!buffer) continue;
    switch (reader_->Read(buffers_[*buffer].data())) {
      case FrameReader::Outcome::kComplete:
        Deliver(*buffer);
        break;
      case FrameReader::Outcome::kDamaged:
        ++damaged_;
        ++num_read_;
        free_.Push(*buffer);
        break;
      case FrameReader::Outcome::kTruncated:
        if (!MustStop())
          Fail(std::string("standard input: ended within a frame; ") +
               reader_->remedy());
        return;
      case FrameReader::Outcome::kEnd:
        return;
    }
  }
}

void PipeSource::Deliver(uint32_t buffer) {
  const uint8_t* planes[3] = {buffers_[buffer].data()};
  for (int i = 1; i < format().num_planes; ++i)
    planes[i] = planes[i - 1] +
                format().planes[i - 1].row_bytes * format().planes[i - 1].rows;
  CapturedFrame frame = {};
  frame.arrived = Clock::now();
  frame.image = MakeImage(format(), planes);
  frame.buffer = buffer;
  frame.info.sequence = num_read_++;
  frame.info.timestamp_ns = static_cast<uint64_t>(
      std::chrono::nanoseconds(frame.arrived.time_since_epoch()).count());
  ++arrived_;
  if (const auto dropped = queue_.Push(frame)) {
    ++dropped_;
    free_.Push(dropped->buffer);
  }
}

void PipeSource::Fail(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  fault_ = why;
}

}  // namespace raygrid
