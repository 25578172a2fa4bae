/// The loop of a live capture: frames in, kept frames and guidance out.
#ifndef RAYGRID_CAPTURE_CAPTURE_LOOP_H
#define RAYGRID_CAPTURE_CAPTURE_LOOP_H

#include <chrono>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "capture/capture_guide.h"
#include "capture/keyframe_selector.h"
#include "capture/live_camera.h"
#include "capture/rig_guide.h"
#include "capture_description.h"
#include "capture_state.h"
#include "captured_camera.h"
#include "paired_frames.h"
#include "session_folder.h"

namespace raygrid {

struct CaptureLoopOptions {
  std::string source;  ///< name for errors
  GuideOptions guide;
  KeyframeSelectorOptions frame_selector;
  int num_threads = 0;
  double timeout_s = 5;  ///< maximum time without a frame
};

/// Callbacks with results; empty ones are not called.
struct CaptureViewers {
  /// Called after each frame set.
  std::function<void(const CaptureState&)> show;
  /// Called before show(), with the grey image that the state describes.
  std::function<void(const GreyImage&)> show_picture;
  /// Called for each kept frame set, also those of a resumed session.
  std::function<void(const std::string& name,
                     const std::vector<const GreyImage*>&)>
      add_kept;
};

/// Requests of users. Thread-safe.
class CaptureRequests {
 public:
  void Pause(bool is_paused);
  void Finish();
  void Undo();
  void Delete(const std::string& name);

 private:
  friend class CaptureLoop;
  std::mutex mutex_;
  bool is_paused_ = false, is_finished_ = false;
  int num_undo_ = 0;
  std::vector<std::string> deleted_;
};

/// Processes frames of a camera, or frame sets of a rig, until the guide
/// reports completion, the source ends, a user requests it or a signal arrives.
/// A frame set is kept if one image contributes enough information about its
/// camera, or several about relative poses; all its good images are kept.
/// Bundle adjustment runs in a separate thread: meanwhile live images are
/// assessed with the last estimate, whereas files wait for it, so that equal
/// files result in equal sessions.
class CaptureLoop {
 public:
  /// All arguments except the options must outlive this object.
  CaptureLoop(const CaptureLoopOptions& options, const Pattern& pattern,
              PairedFrames* frames, SessionFolder* session,
              CaptureViewers viewers, CaptureRequests* wishes);
  ~CaptureLoop();

  /// Throws Error, CameraError, also if no frame arrived; kept frames stay in
  /// the session.
  void Run();
  /// The state after the last frame set.
  const CaptureState& state() const { return state_; }

 private:
  using Update = std::function<void(size_t camera, LiveCamera*)>;

  void Resume();
  void Begin(const FrameSet& frame_set);
  void ProcessFrameSet(const FrameSet& frame_set);
  AssessedFrames Assess(const FrameSet& frame_set);
  bool IsRequested(const AssessedFrames& frames) const;
  void RejectWhileUnlocked(AssessedFrames* frames);
  void Save(AssessedFrames* frames);
  void RecordLock(size_t camera);
  void ApplyRequests();
  void Remove(const std::string& name);
  void UpdateCameras(const std::vector<bool>& changed, const Update& update);
  void MakeGuide(const std::vector<bool>& changed);
  void AdoptGuide(bool wait);
  void SelectDisplayedCamera();
  void Describe(const AssessedFrames& frames);
  void RequestPattern(const ImageFeatures& seen);
  void CountFrameSet();
  void SkipView();
  bool IsFinished();
  const CaptureGuide& guide() const { return *rig_guide_->guide(shown_); }

  CaptureLoopOptions options_;
  const Pattern& pattern_;
  PairedFrames* const frames_;
  SessionFolder* const session_;
  const CaptureViewers viewers_;
  CaptureRequests* const requests_;
  std::deque<CapturedCamera> cameras_;  // not movable
  // Used by the adjustment's thread while it runs.
  std::vector<std::unique_ptr<LiveCamera>> live_;
  std::vector<std::shared_ptr<const CaptureGuide>> camera_guides_;
  std::vector<std::vector<Pose>> avoided_;  // by camera
  std::unique_ptr<RigGuide> next_rig_guide_;
  std::unique_ptr<RigGuide> rig_guide_;
  std::future<void> adjusting_;
  size_t shown_ = 0;  // camera described by the state
  CaptureState state_;
  std::vector<std::string> lock_warnings_;
  std::vector<std::chrono::steady_clock::time_point> taken_;
  bool has_received_frames_ = false, has_failed_to_connect_ = false;
  int num_without_board_ = 0;  // consecutive frame sets
  std::chrono::steady_clock::time_point guidance_start_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_LOOP_H
