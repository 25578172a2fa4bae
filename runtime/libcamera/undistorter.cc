#include "undistorter.h"

#include <string>

namespace raygrid {
namespace {

// The latency of a request to stop.
constexpr std::chrono::milliseconds kFramePatience(50);

// Returns the format of undistorted frames: the camera's, with the size of the
// remap table.
StreamFormat MakeOutputFormat(const rg_camera& camera,
                              const StreamFormat& input) {
  uint16_t width, height;
  if (rg_remap_size(&camera, &width, &height) != RG_OK)
    throw CameraError(CameraExit::kBlob,
                      "blob: has no remap table; pack it with --remap");
  StreamFormat output = MakeStreamFormat(*input.pixel_format, width, height, 0);
  output.is_full_range = input.is_full_range;
  return output;
}

void PrepareFrame(const StreamFormat& format, UndistortedFrame* frame) {
  frame->bytes.resize(format.packed_size());
  frame->target = {};
  uint8_t* plane = frame->bytes.data();
  for (int i = 0; i < format.num_planes; ++i) {
    frame->target.planes[i].data = plane;
    frame->target.planes[i].stride = format.planes[i].stride;
    plane += format.planes[i].row_bytes * format.planes[i].rows;
  }
  frame->target.num_rows = format.height;
  frame->target.kernels = rg_find_kernels(nullptr);
  SetBlackBorder(format, &frame->target);
}

}  // namespace

Undistorter::Undistorter(const rg_camera& camera, FrameSource* source,
                         StreamGuard* guard, const UndistorterOptions& options)
    : camera_(camera),
      source_(source),
      guard_(guard),
      options_(options),
      format_(MakeOutputFormat(camera, source->format())),
      frames_(options.num_buffers),
      bands_(options.num_threads),
      free_(options.num_buffers),
      ready_(options.num_buffers) {
  for (UndistortedFrame& frame : frames_) {
    PrepareFrame(format_, &frame);
    free_.Push(&frame);
  }
  if (options.only_valid) HideInvalidBlocks();
}

void Undistorter::HideInvalidBlocks() {
  invalid_.emplace(camera_, format_, frames_.front().target);
  if (invalid_->are_all())
    throw CameraError(CameraExit::kBlob,
                      "blob: its remap table has no pixel in the valid region; "
                      "omit --outside border, or pack another output view");
}

void Undistorter::Start(FrameObserver* observer) {
  observer_ = observer;
  thread_ = std::thread(&Undistorter::Run, this);
}

UndistortedFrame* Undistorter::Take(std::chrono::milliseconds timeout) {
  return ready_.Pop(timeout).value_or(nullptr);
}

std::optional<CameraError> Undistorter::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return fault_;
}

UndistorterStatistics Undistorter::statistics() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return statistics_;
}

void Undistorter::Stop() {
  is_stopped_ = true;
  if (thread_.joinable()) thread_.join();
}

void Undistorter::Run() {
  try {
    while (!is_stopped_ && !source_->is_finished()) {
      const std::optional<CapturedFrame> captured =
          source_->Next(kFramePatience);
      if (!captured) continue;
      Undistort(*captured);
      source_->Release(*captured);
    }
    if (!source_->fault().empty())
      throw CameraError(CameraExit::kInput, source_->fault());
  } catch (const CameraError& error) {
    const std::lock_guard<std::mutex> lock(mutex_);
    fault_ = error;
  }
  ready_.Close();
}

// Drops the oldest waiting frame to get a buffer, or waits for one; NULL if
// stopped meanwhile.
UndistortedFrame* Undistorter::AcquireBuffer() {
  while (!is_stopped_) {
    if (const auto frame = free_.Pop(std::chrono::milliseconds(0)))
      return *frame;
    if (!options_.every_frame) {
      if (const auto oldest = ready_.Pop(std::chrono::milliseconds(0))) {
        const std::lock_guard<std::mutex> lock(mutex_);
        ++statistics_.dropped;
        return *oldest;
      }
    }
    if (const auto frame = free_.Pop(kFramePatience)) return *frame;
  }
  return nullptr;
}

void Undistorter::Undistort(const CapturedFrame& captured) {
  if (!guard_->Check(captured.info, captured.arrived)) return;
  UndistortedFrame* const frame = AcquireBuffer();
  if (!frame) return;
  stack_.Follow(captured.info);
  const Clock::time_point start = Clock::now();
  const rg_status status =
      bands_.Remap(camera_, captured.image, format_, frame->target);
  if (status != RG_OK)
    throw CameraError(CameraExit::kBlob,
                      std::string("blob: ") + rg_status_text(status));
  if (invalid_) invalid_->FillWithBorder(frame->target);
  frame->remap_time = Clock::now() - start;
  frame->info = captured.info;
  frame->arrived = captured.arrived;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++statistics_.undistorted;
    statistics_.remap.Add(frame->remap_time);
    statistics_.last_info = captured.info;
    statistics_.stack = stack_.counts();
  }
  if (observer_) observer_->OnFrame(captured, *frame);
  ready_.Push(frame);
}

}  // namespace raygrid
