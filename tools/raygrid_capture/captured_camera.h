#ifndef RAYGRID_CAPTURE_CAPTURED_CAMERA_H
#define RAYGRID_CAPTURE_CAPTURED_CAMERA_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame_assessor.h"
#include "features/pattern_detector.h"
#include "live_frames.h"
#include "session_file.h"

namespace raygrid {

/// One camera of a capture: finds boards in its frames, judges them, and keeps
/// the camera as it is.
class CapturedCamera {
 public:
  CapturedCamera(const Pattern& pattern, const FrameAssessorOptions& options);

  /// The boards of a frame, without a name. Any thread may call it.
  DetectedFrame See(const LiveFrame& frame) const;
  ImageFeatures Detect(const std::string& name, const GreyImage& grey) const;

  /// Judges frames in the order in which they came.
  FrameStatus Assess(const DetectedFrame& seen, const CaptureGuide& guide);

  /// The word on a frame that is good enough to be kept, where the camera's
  /// state forbids it: "locking", "refocused", "cropped"; "" where it does not.
  /// The first such frame locks the camera, source, if there is one. first is
  /// the state of its first kept frame, or NULL.
  std::string GetStateText(const LiveFrame& frame, FrameSource* source,
                           const SessionFrame* first);
  /// The lock that GetStateText() has just made, once; nothing else.
  std::optional<StateLock> TakeLock();

  /// How the camera stood in a frame, and how good that is.
  SessionFrame RecordOf(const LiveFrame& frame,
                        const DetectedFrame& seen) const;

 private:
  bool IsLocking(const LiveFrame& frame, FrameSource* source,
                 const SessionFrame* first);

  Pattern pattern_;
  PatternDetector detector_;
  std::map<int, QualityMeter> meters_;  // by board
  FrameAssessor judge_;
  std::optional<Clock::time_point> lock_time_;
  bool is_locked_ = false;
  std::optional<StateLock> new_lock_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURED_CAMERA_H
