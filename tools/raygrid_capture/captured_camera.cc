#include "captured_camera.h"

#include <algorithm>
#include <cmath>

#include "camera_session.h"

namespace raygrid {
namespace {

// Returns the board of the pattern with the most features in an image; NULL
// without features.
const Board* FindLargestBoard(const Pattern& pattern,
                              const ImageFeatures& image) {
  const Board* largest = nullptr;
  std::ptrdiff_t most = 0;
  for (const Board& board : pattern.boards) {
    const auto count = std::count_if(
        image.features.begin(), image.features.end(),
        [&board](const Feature& feature) { return feature.board == board.id; });
    if (count <= most) continue;
    most = count;
    largest = &board;
  }
  return largest;
}

std::optional<double> FiniteOrNull(double value) {
  return value > 0 ? std::optional(value) : std::nullopt;
}

// Returns the capture settings of a frame.
SessionFrame MakeSessionFrame(const FrameInfo& info) {
  SessionFrame record;
  record.lens_position = info.lens_position;
  record.focus_steps = info.focus_steps;
  record.exposure_us = info.exposure_us;
  record.analogue_gain = info.analogue_gain;
  record.zoom = info.zoom;
  record.orientation = info.orientation;
  record.sensor_temperature_c = info.sensor_temperature_c;
  if (info.crop)
    record.crop = {info.crop->x, info.crop->y,
                   static_cast<int>(info.crop->width),
                   static_cast<int>(info.crop->height)};
  return record;
}

LensFocus MakeLensFocus(const SessionFrame& frame) {
  LensFocus focus;
  if (frame.lens_position)
    focus.lens_position = static_cast<float>(*frame.lens_position);
  focus.focus_steps = frame.focus_steps;
  return focus;
}

// Returns the status of a frame whose capture settings differ from those of the
// first kept one: the lens has moved, or the sensor crop has changed. NULL: no
// difference.
const char* DescribeOtherCameraState(const SessionFrame& first,
                                     const SessionFrame& now) {
  const bool has_lens_moved =
      first.lens_position && now.lens_position &&
      std::abs(*first.lens_position - *now.lens_position) >
          kDefaultLensTolerance;
  if (has_lens_moved || first.focus_steps != now.focus_steps)
    return "refocused";
  return first.crop != now.crop || first.zoom != now.zoom ? "cropped" : nullptr;
}

}  // namespace

CapturedCamera::CapturedCamera(const Pattern& pattern,
                               const KeyframeSelectorOptions& options)
    : pattern_(pattern), detector_(pattern, {}), frame_selector_(options) {
  for (const Board& board : pattern_.boards)
    meters_.emplace(board.id, QualityMeter(board));
}

ImageFeatures CapturedCamera::Detect(const std::string& name,
                                     const GreyImage& grey) const {
  return {name, detector_.Detect(grey).features};
}

DetectedFrame CapturedCamera::See(const LiveFrame& frame) const {
  DetectedFrame seen;
  seen.features = Detect("", frame.grey);
  seen.time_s = frame.time_s;
  if (frame.info.exposure_us) seen.exposure_s = *frame.info.exposure_us * 1e-6;
  if (const Board* const board = FindLargestBoard(pattern_, seen.features)) {
    std::vector<Feature> own;
    for (const Feature& feature : seen.features.features)
      if (feature.board == board->id) own.push_back(feature);
    seen.quality =
        meters_.at(board->id).Measure(frame.grey.size, frame.grey.levels, own);
  }
  return seen;
}

FrameStatus CapturedCamera::Assess(const DetectedFrame& seen,
                                   const CaptureGuide& guide) {
  return frame_selector_.Assess(seen, guide);
}

std::string CapturedCamera::GetStateText(const LiveFrame& frame,
                                         FrameSource* source,
                                         const SessionFrame* first) {
  if (IsLocking(frame, source, first)) return "locking";
  const char* const other =
      first ? DescribeOtherCameraState(*first, MakeSessionFrame(frame.info))
            : nullptr;
  return other ? other : "";
}

// Locks the camera's settings once a frame is good enough to be kept. The
// metadata of frames that arrived before, or shortly after, may not reflect the
// lock: V4L2 controls are read once per second.
bool CapturedCamera::IsLocking(const LiveFrame& frame, FrameSource* source,
                               const SessionFrame* first) {
  constexpr std::chrono::milliseconds kSettlingTime(1200);
  if (!lock_time_) {
    lock_time_ = Clock::now();
    // A resumed session restores its focus.
    if (source && first) source->FocusAt(MakeLensFocus(*first));
    if (source) new_lock_ = source->LockState();
    is_locked_ = new_lock_ && !new_lock_->locked.empty();
  }
  return is_locked_ && frame.arrived < *lock_time_ + kSettlingTime;
}

std::optional<StateLock> CapturedCamera::TakeLock() {
  std::optional<StateLock> lock;
  lock.swap(new_lock_);
  return lock;
}

SessionFrame CapturedCamera::MakeRecord(const LiveFrame& frame,
                                        const DetectedFrame& seen) const {
  SessionFrame record = MakeSessionFrame(frame.info);
  record.image = seen.features.image;
  record.seconds = frame.time_s;
  record.edge_spread_px = FiniteOrNull(seen.quality.max_spread_px);
  record.white = FiniteOrNull(seen.quality.white);
  record.variance_reduction = frame_selector_.gain();
  return record;
}

}  // namespace raygrid
