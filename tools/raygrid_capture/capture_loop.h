/// The loop of a live capture: frames in, kept frames and guidance out.
#ifndef RAYGRID_CAPTURE_CAPTURE_LOOP_H
#define RAYGRID_CAPTURE_CAPTURE_LOOP_H

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "capture/capture_guide.h"
#include "capture/frame_judge.h"
#include "capture/live_camera.h"
#include "capture_state.h"
#include "features/pattern_detector.h"
#include "live_frames.h"
#include "session_folder.h"

namespace raygrid {

struct CaptureLoopOptions {
  std::string source;  ///< for errors
  GuideOptions guide;
  JudgeOptions judge;
  int num_threads = 0;
  double timeout_s = 5;  ///< without a frame
};

/// The ones who are told; those that are empty are not.
struct CaptureViewers {
  /// After each frame.
  std::function<void(const CaptureState&)> show;
  /// The frame's grey levels, before that.
  std::function<void(const GreyImage&)> show_picture;
  /// A frame was kept, or is there from the start.
  std::function<void(const std::string& name, const GreyImage&)> add_kept;
};

/// Wishes of people. Any thread may have some.
class CaptureWishes {
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

/// Takes frames until the guide says done, the source ends, someone wishes it
/// or a signal comes. The camera is adjusted by a thread of its own: a live
/// source's frames are judged meanwhile, by what was known before; those of
/// files wait for it, so that the same files give the same session.
class CaptureLoop {
 public:
  /// All but the options outlive it.
  CaptureLoop(const CaptureLoopOptions& options, const Pattern& pattern,
              LiveFrames* frames, SessionFolder* session,
              CaptureViewers viewers, CaptureWishes* wishes);
  ~CaptureLoop();

  /// Throws Error, CameraError, also where no frame came; what was kept is in
  /// the session.
  void Run();
  /// The state after the last frame.
  const CaptureState& state() const { return state_; }

 private:
  using Update = std::function<void(LiveCamera*)>;

  void Resume();
  void TakeFrame(const LiveFrame& frame);
  bool IsKept(const LiveFrame& frame, const SeenFrame& seen);
  void Keep(const LiveFrame& frame, const SeenFrame& seen);
  bool IsLocking(const LiveFrame& frame);
  void LockCamera();
  void FollowWishes();
  void Remove(const std::string& name);
  void UpdateCamera(Update update);
  void TakeGuide(bool wait);
  SeenFrame See(const LiveFrame& frame) const;
  void Describe(const LiveFrame& frame, const SeenFrame& seen);
  void DescribeKnown();
  void DescribeNext(const SeenFrame& seen);
  void CountFrame();
  void LeaveViewInVain();
  bool IsFinished();

  CaptureLoopOptions options_;
  const Pattern& pattern_;
  LiveFrames* const frames_;
  SessionFolder* const session_;
  const CaptureViewers viewers_;
  CaptureWishes* const wishes_;
  PatternDetector detector_;
  std::map<int, QualityMeter> meters_;  // by board
  FrameJudge judge_;
  std::unique_ptr<LiveCamera> live_;  // of the thread while it adjusts
  std::unique_ptr<CaptureGuide> guide_;
  std::future<std::unique_ptr<CaptureGuide>> adjusting_;
  CaptureState state_;
  std::vector<std::chrono::steady_clock::time_point> taken_;
  std::optional<std::chrono::steady_clock::time_point> lock_time_;
  bool is_locked_ = false;
  bool has_seen_frames_ = false;
  int num_without_board_ = 0;  // frames, one after the other
  std::chrono::steady_clock::time_point guided_since_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_LOOP_H
