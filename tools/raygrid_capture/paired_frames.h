/// Synchronized frames of the cameras of a rig.
#ifndef RAYGRID_CAPTURE_PAIRED_FRAMES_H
#define RAYGRID_CAPTURE_PAIRED_FRAMES_H

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "live_frames.h"

namespace raygrid {

/// A frame set: synchronized frames of all cameras; nullopt for cameras without
/// one.
using FrameSet = std::vector<std::optional<LiveFrame>>;

struct CameraStream {
  std::string camera;  ///< empty: single camera
  std::unique_ptr<LiveFrames> frames;
};

/// Pairs frames of live cameras by their timestamps, photographs by their
/// names, and frames of videos by their numbers. Frames of a single camera are
/// passed on.
///
/// If no pair was found for a second, unpaired live frames are returned alone,
/// because each still contributes to its own camera.
class PairedFrames {
 public:
  /// Frames of live cameras are synchronized if their timestamps differ by no
  /// more than the tolerance. Throws Error(kUsage) if live cameras, videos and
  /// folders are mixed.
  PairedFrames(std::vector<CameraStream> cameras, double tolerance_s);

  size_t size() const { return cameras_.size(); }
  const std::string& name(size_t camera) const {
    return cameras_[camera].camera;
  }
  std::vector<std::string> names() const;
  /// Returns the camera; NULL for files.
  FrameSource* source(size_t camera) const {
    return cameras_[camera].frames->source();
  }

  /// Returns the next frame set; nullopt if none arrives soon. Throws
  /// InputError, CameraError.
  std::optional<FrameSet> Next();
  /// Files: whether all were returned. Cameras: whether one of them has ended.
  bool is_finished() const;
  bool is_live() const { return cameras_[0].frames->is_live(); }
  /// Whether live frames arrive, but no pair was found for a second.
  bool is_unpaired() const { return is_unpaired_; }

 private:
  bool FillPending();
  FrameSet PopPending(const std::vector<bool>& taken);
  std::optional<FrameSet> NextLive();
  std::optional<FrameSet> ReadNextFiles();

  std::vector<CameraStream> cameras_;
  const double tolerance_s_;
  FrameSet pending_;  // frames waiting for others of their set
  Clock::time_point last_pair_;
  bool is_unpaired_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_PAIRED_FRAMES_H
