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
#include "capture/frame_assessor.h"
#include "capture/live_camera.h"
#include "capture/rig_guide.h"
#include "capture_description.h"
#include "capture_state.h"
#include "captured_camera.h"
#include "paired_frames.h"
#include "session_folder.h"

namespace raygrid {

struct CaptureLoopOptions {
  std::string source;  ///< for errors
  GuideOptions guide;
  FrameAssessorOptions judge;
  int num_threads = 0;
  double timeout_s = 5;  ///< without a frame
};

/// The ones who are told; those that are empty are not.
struct CaptureViewers {
  /// After each instant.
  std::function<void(const CaptureState&)> show;
  /// The grey levels of the frame that the state tells of, before that.
  std::function<void(const GreyImage&)> show_picture;
  /// An instant was kept, or is there from the start: the frames that it has.
  std::function<void(const std::string& name,
                     const std::vector<const GreyImage*>&)>
      add_kept;
};

/// Wishes of people. Any thread may have some.
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

/// Takes frames of a camera, or of a rig's cameras at one instant each, until
/// the guide says done, the source ends, someone wishes it or a signal comes.
/// An instant is kept if one of its frames tells enough of its camera, or some
/// together of how cameras stand to each other; all its good frames are.
/// Cameras are adjusted by a thread of its own: live frames are judged
/// meanwhile, by what was known before; those of files wait for it, so that the
/// same files give the same session.
class CaptureLoop {
 public:
  /// All but the options outlive it.
  CaptureLoop(const CaptureLoopOptions& options, const Pattern& pattern,
              PairedFrames* frames, SessionFolder* session,
              CaptureViewers viewers, CaptureRequests* wishes);
  ~CaptureLoop();

  /// Throws Error, CameraError, also where no frame came; what was kept is in
  /// the session.
  void Run();
  /// The state after the last instant.
  const CaptureState& state() const { return state_; }

 private:
  using Update = std::function<void(size_t camera, LiveCamera*)>;

  void Resume();
  void Begin(const FrameSet& instant);
  void ProcessFrameSet(const FrameSet& instant);
  AssessedFrames Assess(const FrameSet& instant);
  bool IsRequested(const AssessedFrames& frames) const;
  void Forbid(AssessedFrames* frames);
  void Save(AssessedFrames* frames);
  void RecordLock(size_t camera);
  void ApplyRequests();
  void Remove(const std::string& name);
  void UpdateCameras(const std::vector<bool>& changed, const Update& update);
  void MakeGuide(const std::vector<bool>& changed);
  void TakeGuide(bool wait);
  void ChooseCameraShown();
  void Describe(const AssessedFrames& frames);
  void AskForPattern(const ImageFeatures& seen);
  void CountFrameSet();
  void SkipView();
  bool IsFinished();
  const CaptureGuide& guide() const { return *guide_->guide(shown_); }

  CaptureLoopOptions options_;
  const Pattern& pattern_;
  PairedFrames* const frames_;
  SessionFolder* const session_;
  const CaptureViewers viewers_;
  CaptureRequests* const wishes_;
  std::deque<CapturedCamera> cameras_;  // they cannot be moved
  // The thread has these while it adjusts.
  std::vector<std::unique_ptr<LiveCamera>> live_;
  std::vector<std::shared_ptr<const CaptureGuide>> guides_;
  std::vector<std::vector<Pose>> avoided_;  // by camera
  std::unique_ptr<RigGuide> next_guide_;
  std::unique_ptr<RigGuide> guide_;
  std::future<void> adjusting_;
  size_t shown_ = 0;  // the camera that the state tells of
  CaptureState state_;
  std::vector<std::string> lock_remarks_;
  std::vector<std::chrono::steady_clock::time_point> taken_;
  bool has_seen_frames_ = false, has_connected_in_vain_ = false;
  int num_without_board_ = 0;  // instants, one after the other
  std::chrono::steady_clock::time_point guided_since_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_LOOP_H
