#include "v4l2_source.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "camera_error.h"
#include "v4l2_controls.h"

namespace raygrid {
namespace {

constexpr uint32_t kNumBuffers = 4;
// Buffers for JPEG pixels: one is undistorted, one decoded, others wait.
constexpr uint32_t kNumDecoded = 4;
// The latency of a request to stop.
constexpr int kPatience_ms = 50;
// Consecutive failed calls after which the device is given up.
constexpr int kMaxFailures = 20;
constexpr std::chrono::milliseconds kPauseAfterFailure(5);
// The latency of detecting a zoom or a flip. USB cameras need a separate
// transfer for each query.
constexpr std::chrono::seconds kTellingTime(1);

std::string StartRemedy(int error) {
  if (error == ENOSPC)
    return "unplug other cameras from that USB bus, or use a smaller --size";
  if (error == EPIPE || error == ENOLINK)
    return "configure its media pipeline for this size with media-ctl";
  return "reconnect it";
}

}  // namespace

V4l2Source::V4l2Source(std::unique_ptr<V4l2Device> device,
                       const V4l2Options& options)
    : device_(std::move(device)),
      state_(device_.get()),
      decode_jpeg_(options.decode_jpeg),
      free_(kNumDecoded) {
  FindBufferType(device_.get());
  SetV4l2Controls(device_.get(), options.controls);
  stream_ = ChooseStream(device_.get(), options.format, options.width,
                         options.height, decode_jpeg_ != nullptr);
  buffers_ = std::make_unique<V4l2Buffers>(device_.get(), stream_, kNumBuffers);
  reader_ = std::make_unique<V4l2CaptureReader>(device_.get());
  const uint32_t number = stream_.is_jpeg ? kNumDecoded : buffers_->number();
  queue_ = std::make_unique<BoundedQueue<CapturedFrame>>(
      options.every_frame ? number : number / 2);
  if (!stream_.is_jpeg) return;
  decoded_.resize(kNumDecoded);
  for (uint32_t i = 0; i < kNumDecoded; ++i) {
    decoded_[i].resize(stream_.format.packed_size());
    free_.Push(i);
  }
}

void V4l2Source::Start() {
  int type = static_cast<int>(stream_.buffer_type);
  const int status = IoctlWithRetry(device_.get(), VIDIOC_STREAMON, &type);
  if (status != 0)
    throw V4l2Error(*device_, "failed to start", status, StartRemedy(status));
  is_streaming_ = true;
  thread_ = std::thread(&V4l2Source::Run, this);
}

std::optional<CapturedFrame> V4l2Source::Next(
    std::chrono::milliseconds timeout) {
  return queue_->Pop(timeout);
}

void V4l2Source::Release(const CapturedFrame& frame) {
  if (stream_.is_jpeg) {
    free_.Push(frame.buffer);
    return;
  }
  buffers_->EndRead(frame.buffer);
  Queue(frame.buffer);
}

std::string V4l2Source::memory() const {
  return stream_.is_jpeg
             ? buffers_->memory() +
                   "; decoded JPEG pixels: in memory of this program"
             : buffers_->memory();
}

std::string V4l2Source::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return fault_;
}

SourceCounts V4l2Source::counts() const {
  return {arrived_, dropped_, damaged_, missed_};
}

StateLock V4l2Source::LockState() {
  if (is_stopped_ || !fault().empty())
    return MakeUnlockedState("the stream has ended");
  if (arrived_ == 0) return MakeUnlockedState("no frame received yet");
  const StateLock lock = state_.Lock();
  has_changed_ = true;
  return lock;
}

void V4l2Source::UnlockState() {
  state_.Unlock();
  has_changed_ = true;
}

void V4l2Source::Stop() {
  is_stopped_ = true;
  if (thread_.joinable()) thread_.join();
  state_.Unlock();
  if (!is_streaming_) return;
  is_streaming_ = false;
  int type = static_cast<int>(stream_.buffer_type);
  IoctlWithRetry(device_.get(), VIDIOC_STREAMOFF, &type);
}

void V4l2Source::Run() {
  while (!is_stopped_) {
    const short events = device_->Wait(kPatience_ms);
    if (events != 0 && !TakeFrame(events)) break;
  }
  queue_->Close();
}

// Returns whether frames may still come.
bool V4l2Source::TakeFrame(short events) {
  V4l2Filled filled;
  int status = buffers_->Dequeue(&filled);
  if (status == 0) {
    num_failures_ = 0;
    Deliver(filled);
    return true;
  }
  const bool has_failed = (events & (POLLERR | POLLHUP | POLLNVAL)) != 0;
  if (status == EAGAIN && !has_failed) return true;
  if (status == EAGAIN && (events & POLLHUP)) status = ENODEV;
  if (status == EAGAIN) status = EIO;
  // Drivers may recover from EIO, such as when a signal was lost.
  if (status == EIO && ++num_failures_ <= kMaxFailures) {
    std::this_thread::sleep_for(kPauseAfterFailure);
    return true;
  }
  Fail(status);
  return false;
}

void V4l2Source::Fail(int error) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!fault_.empty()) return;
  fault_ = error == ENODEV
               ? "camera: disconnected; reconnect it"
               : std::string("camera: stopped delivering frames (") +
                     std::strerror(error) + "); reconnect it";
}

void V4l2Source::CountMissed(uint32_t sequence) {
  if (last_sequence_ && sequence > *last_sequence_)
    missed_ += sequence - *last_sequence_ - 1;
  last_sequence_ = sequence;
}

void V4l2Source::Deliver(const V4l2Filled& filled) {
  CountMissed(filled.sequence);
  if (!filled.is_whole || !buffers_->BeginRead(filled.buffer)) {
    ++damaged_;
    return Queue(filled.buffer);
  }
  const Clock::time_point arrived = Clock::now();
  if (stream_.is_jpeg) return Decode(filled, arrived);
  Push(filled, buffers_->planes(filled.buffer).data(), filled.buffer, arrived);
}

// Returns a free buffer for pixels; nullopt if stopped before one is free.
std::optional<uint32_t> V4l2Source::PopDecoded() {
  while (!is_stopped_)
    if (const auto place = free_.Pop(std::chrono::milliseconds(kPatience_ms)))
      return place;
  return std::nullopt;
}

// The driver's buffer is released as soon as its pixels are decoded.
void V4l2Source::Decode(const V4l2Filled& filled, Clock::time_point arrived) {
  const std::optional<uint32_t> place = PopDecoded();
  if (!place) return;
  uint8_t* const pixels = decoded_[*place].data();
  const bool is_good = decode_jpeg_(buffers_->planes(filled.buffer)[0],
                                    filled.num_bytes, stream_.format, pixels);
  buffers_->EndRead(filled.buffer);
  Queue(filled.buffer);
  if (is_good) {
    const uint8_t* const planes[3] = {pixels};
    return Push(filled, planes, *place, arrived);
  }
  ++damaged_;
  free_.Push(*place);
}

void V4l2Source::Push(const V4l2Filled& filled, const uint8_t* const planes[3],
                      uint32_t buffer, Clock::time_point arrived) {
  if (has_changed_.exchange(false) || reported_at_ == Clock::time_point() ||
      arrived - reported_at_ >= kTellingTime) {
    reader_->Read(&reported_);
    reported_at_ = arrived;
  }
  CapturedFrame frame = {};
  frame.arrived = arrived;
  frame.info = reported_;
  frame.image = MakeImage(stream_.format, planes);
  frame.buffer = buffer;
  frame.info.sequence = filled.sequence;
  frame.info.timestamp_ns = filled.timestamp_ns;
  ++arrived_;
  if (const auto dropped = queue_->Push(frame)) {
    ++dropped_;
    Release(*dropped);
  }
}

// Called by the undistorter's thread or the source's own.
void V4l2Source::Queue(uint32_t buffer) {
  if (is_stopped_) return;
  const int status = buffers_->Queue(buffer);
  if (status == 0) return;
  Fail(status);
  queue_->Close();
}

}  // namespace raygrid
