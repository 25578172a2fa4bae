/// Frames that the cameras of a rig took at one instant.
#ifndef RAYGRID_CAPTURE_PAIRED_FRAMES_H
#define RAYGRID_CAPTURE_PAIRED_FRAMES_H

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "live_frames.h"

namespace raygrid {

/// The frames of all cameras that were taken at one instant; nothing of a
/// camera that has none.
using FrameSet = std::vector<std::optional<LiveFrame>>;

struct NamedFrames {
  std::string camera;  ///< empty: the only one
  std::unique_ptr<LiveFrames> frames;
};

/// Pairs frames of live cameras by their time stamps, photographs by their
/// names, and frames of videos by their numbers. Frames of a single camera are
/// passed on.
///
/// Live frames without a partner are given alone once no pair was found for a
/// second: each still tells of its own camera.
class PairedFrames {
 public:
  /// Frames of live cameras are of one instant if their time stamps differ by
  /// no more than the tolerance. Throws Error(kUsage) where live cameras,
  /// videos and folders are mixed.
  PairedFrames(std::vector<NamedFrames> cameras, double tolerance_s);

  size_t size() const { return cameras_.size(); }
  const std::string& name(size_t camera) const {
    return cameras_[camera].camera;
  }
  std::vector<std::string> names() const;
  /// The camera behind; NULL for files.
  FrameSource* source(size_t camera) const {
    return cameras_[camera].frames->source();
  }

  /// The next frames; nothing when none come soon. Throws InputError,
  /// CameraError.
  std::optional<FrameSet> Next();
  /// Files: all were taken. Cameras: one of them has ended.
  bool is_finished() const;
  bool is_live() const { return cameras_[0].frames->is_live(); }
  /// Live frames come, and for a second no two of them within the tolerance.
  bool is_unpaired() const { return is_unpaired_; }

 private:
  bool FillPending();
  FrameSet TakePending(const std::vector<bool>& taken);
  std::optional<FrameSet> NextLive();
  std::optional<FrameSet> NextOfFiles();

  std::vector<NamedFrames> cameras_;
  const double tolerance_s_;
  FrameSet pending_;  // frames that wait for others of their instant
  Clock::time_point last_pair_;
  bool is_unpaired_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_PAIRED_FRAMES_H
