#ifndef RAYGRID_CAPTURE_CAPTURED_CAMERA_H
#define RAYGRID_CAPTURE_CAPTURED_CAMERA_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/keyframe_selector.h"
#include "features/pattern_detector.h"
#include "live_frames.h"
#include "session_file.h"

namespace raygrid {

/// One camera of a capture: detects boards in its frames, assesses them, and
/// checks that the camera's settings stay constant.
class CapturedCamera {
 public:
  CapturedCamera(const Pattern& pattern,
                 const KeyframeSelectorOptions& options);

  /// Detects the boards of a frame, without a name. Thread-safe.
  DetectedFrame See(const LiveFrame& frame) const;
  ImageFeatures Detect(const std::string& name, const GreyImage& grey) const;

  /// Assesses frames, in the order of their capture.
  FrameStatus Assess(const DetectedFrame& seen, const CaptureGuide& guide);

  /// Returns the status of a good frame that the camera's settings prevent from
  /// being kept: "locking", "refocused", "cropped"; otherwise "". The first
  /// such frame locks the settings of source, unless NULL. first: record of the
  /// first kept frame, or NULL.
  std::string GetStateText(const LiveFrame& frame, FrameSource* source,
                           const SessionFrame* first);
  /// Returns the lock that GetStateText() has made, once; otherwise nullopt.
  std::optional<StateLock> TakeLock();

  /// Returns the capture settings and quality of a frame.
  SessionFrame MakeRecord(const LiveFrame& frame,
                          const DetectedFrame& seen) const;

 private:
  bool IsLocking(const LiveFrame& frame, FrameSource* source,
                 const SessionFrame* first);

  Pattern pattern_;
  PatternDetector detector_;
  std::map<int, QualityMeter> meters_;  // by board
  KeyframeSelector frame_selector_;
  std::optional<Clock::time_point> lock_time_;
  bool is_locked_ = false;
  std::optional<StateLock> new_lock_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURED_CAMERA_H
