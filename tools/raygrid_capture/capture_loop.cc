#include "capture_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "camera_error.h"
#include "camera_session.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

using SteadyClock = std::chrono::steady_clock;

double SecondsSince(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

void RequireSize(const Session& session, const ImageSize& size) {
  if (session.frames.empty() || session.image_size == size) return;
  throw Error(ExitCode::kUsage,
              fmt::format("the session's frames have {} x {} pixels, the "
                          "source's {} x {}; use the same --size",
                          session.image_size.width, session.image_size.height,
                          size.width, size.height));
}

// Returns the warning at the end if the target uncertainty was not reached.
std::string TargetWarning(const CaptureState& state) {
  if (!(state.target_px > 0) || state.kept.empty()) return "";
  const bool is_known = state.stddev_px > 0;
  if (is_known && !state.stddev_is_floor && state.stddev_px <= state.target_px)
    return "";
  return fmt::format(
      "--until {:g}px was not reached: {} after {} frames; {}", state.target_px,
      is_known ? fmt::format("uncertainty {:.2g} px in 95 % of the image{}",
                             state.stddev_px,
                             state.stddev_is_floor ? " (lower bound)" : "")
               : "no estimate of the camera",
      state.kept.size(),
      state.is_done ? "further views add little"
                    : "add more views with --resume");
}

bool HasFrame(const Session& session, const std::string& name) {
  return std::any_of(
      session.frames.begin(), session.frames.end(),
      [&name](const SessionFrame& frame) { return frame.image == name; });
}

}  // namespace

void CaptureRequests::Pause(bool is_paused) {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_paused_ = is_paused;
}

void CaptureRequests::Finish() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_finished_ = true;
}

void CaptureRequests::Undo() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++num_undo_;
}

void CaptureRequests::Delete(const std::string& name) {
  const std::lock_guard<std::mutex> lock(mutex_);
  deleted_.push_back(name);
}

CaptureLoop::CaptureLoop(const CaptureLoopOptions& options,
                         const Pattern& pattern, PairedFrames* frames,
                         SessionFolder* session, CaptureViewers viewers,
                         CaptureRequests* wishes)
    : options_(options),
      pattern_(pattern),
      frames_(frames),
      session_(session),
      viewers_(std::move(viewers)),
      requests_(wishes),
      live_(frames->size()),
      camera_guides_(frames->size()),
      avoided_(frames->size()) {
  for (size_t c = 0; c < frames->size(); ++c)
    cameras_.emplace_back(pattern, options.frame_selector);
  state_.target_px = options.guide.target_px;
}

CaptureLoop::~CaptureLoop() {
  if (adjusting_.valid()) adjusting_.wait();
}

void CaptureLoop::Run() {
  auto last = SteadyClock::now();
  while (!IsFinished()) {
    ApplyRequests();
    AdoptGuide(false);
    if (const auto frame_set = frames_->Next()) {
      ProcessFrameSet(*frame_set);
      last = SteadyClock::now();
    } else if (frames_->is_live() && !frames_->is_finished() &&
               SecondsSince(last) > options_.timeout_s) {
      throw CameraError(CameraExit::kInput,
                        "no frame from the source within --timeout; reconnect "
                        "it and continue with --resume, or increase --timeout");
    }
  }
  if (!has_received_frames_ && frames_->is_finished() && !IsSignalled())
    throw InputError(options_.source + ": contains no readable frame");
  ApplyRequests();
  AdoptGuide(true);
  if (!rig_guide_) return;
  state_.is_done = rig_guide_->is_done();
  if (!state_.kept.empty()) state_.hint = state_.is_done ? "done" : "finished";
  DescribeKnown(*rig_guide_, shown_, &state_);
  if (const std::string warning = TargetWarning(state_); !warning.empty())
    state_.warnings.push_back(warning);
  if (viewers_.show) viewers_.show(state_);
}

bool CaptureLoop::IsFinished() {
  if (IsSignalled() || frames_->is_finished()) return true;
  const std::lock_guard<std::mutex> lock(requests_->mutex_);
  return requests_->is_finished_ || (rig_guide_ && rig_guide_->is_done());
}

// ---- Camera estimates ------------------------------------------------------

void CaptureLoop::UpdateCameras(const std::vector<bool>& changed,
                                const Update& update) {
  AdoptGuide(true);
  adjusting_ = std::async(std::launch::async, [this, changed, update] {
    for (size_t c = 0; c < live_.size(); ++c)
      if (changed[c]) update(c, live_[c].get());
    MakeGuide(changed);
  });
  if (!frames_->is_live()) AdoptGuide(true);
}

void CaptureLoop::MakeGuide(const std::vector<bool>& changed) {
  GuideOptions options = options_.guide;
  options.skip_connecting_views = has_failed_to_connect_;
  std::vector<GuidedCamera> cameras(live_.size());
  for (size_t c = 0; c < live_.size(); ++c) {
    if (!live_[c]) continue;
    options.avoided = avoided_[c];
    if (changed[c] || !camera_guides_[c])
      camera_guides_[c] =
          std::make_shared<CaptureGuide>(*live_[c], pattern_, options);
    cameras[c] = {live_[c].get(), camera_guides_[c], avoided_[c]};
  }
  next_rig_guide_ = std::make_unique<RigGuide>(cameras, pattern_, options);
}

void CaptureLoop::AdoptGuide(bool wait) {
  if (adjusting_.valid()) {
    if (!wait && adjusting_.wait_for(std::chrono::seconds(0)) !=
                     std::future_status::ready)
      return;
    adjusting_.get();
  }
  if (!next_rig_guide_) return;
  rig_guide_ = std::move(next_rig_guide_);
  guidance_start_ = SteadyClock::now();
  SelectDisplayedCamera();
}

void CaptureLoop::SelectDisplayedCamera() {
  if (rig_guide_->next())
    shown_ = rig_guide_->next()->camera;
  else if (rig_guide_->to_connect())
    shown_ = rig_guide_->to_connect()->first;
  if (!rig_guide_->guide(shown_))
    for (shown_ = 0; !rig_guide_->guide(shown_);) ++shown_;
}

// Skips a suggested view after some time: the board may not fit there or not be
// detected, or two cameras may have no common field of view.
void CaptureLoop::SkipView() {
  constexpr double kPatienceS = 20;
  if (!frames_->is_live() || adjusting_.valid() || state_.is_paused ||
      SecondsSince(guidance_start_) < kPatienceS)
    return;
  std::vector<bool> changed(live_.size(), false);
  if (rig_guide_->to_connect() && !rig_guide_->next()) {
    if (has_failed_to_connect_) return;
    has_failed_to_connect_ = true;
  } else if (guide().information() && rig_guide_->next()) {
    avoided_[shown_].push_back(rig_guide_->next()->view.camera_from_board);
    changed[shown_] = true;
  } else {
    return;
  }
  UpdateCameras(changed, [](size_t, LiveCamera*) {});
}

// Detects the features of the session's existing frames again.
void CaptureLoop::Resume() {
  std::vector<std::vector<ImageFeatures>> images(cameras_.size());
  for (const std::string& name : session_->CollectFrameSets()) {
    std::vector<GreyImage> greys;
    for (size_t c = 0; c < cameras_.size(); ++c) {
      if (!HasFrame(session_->cameras()[c], name)) continue;
      greys.push_back(
          MakeGreyImage(ReadGreyLevels(session_->MakePath(c, name))));
      images[c].push_back(cameras_[c].Detect(name, greys.back()));
    }
    std::vector<const GreyImage*> shown;
    for (const GreyImage& grey : greys) shown.push_back(&grey);
    if (viewers_.add_kept) viewers_.add_kept(name, shown);
    state_.kept.push_back(name);
  }
  if (state_.kept.empty()) return;
  std::vector<bool> changed(cameras_.size(), false);
  for (size_t c = 0; c < cameras_.size(); ++c) {
    changed[c] = !images[c].empty();
    if (changed[c])
      live_[c] = std::make_unique<LiveCamera>(
          pattern_, session_->cameras()[c].image_size, options_.num_threads);
  }
  UpdateCameras(changed,
                [images](size_t c, LiveCamera* live) { live->Add(images[c]); });
  AdoptGuide(true);
}

// The cameras' formats are known only after their first frames.
void CaptureLoop::Begin(const FrameSet& frame_set) {
  if (!has_received_frames_) Resume();
  has_received_frames_ = true;
  bool is_new = false;
  for (size_t c = 0; c < frame_set.size(); ++c) {
    if (!frame_set[c]) continue;
    const ImageSize& size = frame_set[c]->grey.size;
    RequireSize(session_->cameras()[c], size);
    is_new |= !rig_guide_ || !rig_guide_->guide(c);
    if (live_[c]) continue;
    AdoptGuide(true);
    live_[c] =
        std::make_unique<LiveCamera>(pattern_, size, options_.num_threads);
  }
  if (!is_new) return;
  AdoptGuide(true);
  MakeGuide(std::vector<bool>(live_.size(), false));
  AdoptGuide(true);
}

// ---- Frame sets ------------------------------------------------------------

void CaptureLoop::ProcessFrameSet(const FrameSet& frame_set) {
  Begin(frame_set);
  AssessedFrames assessed_frames = Assess(frame_set);
  if (IsRequested(assessed_frames)) {
    RejectWhileUnlocked(&assessed_frames);
    if (IsRequested(assessed_frames)) Save(&assessed_frames);
  }
  CountFrameSet();
  SkipView();
  Describe(assessed_frames);
  if (viewers_.show_picture && assessed_frames[shown_].frame)
    viewers_.show_picture(assessed_frames[shown_].frame->grey);
  if (viewers_.show) viewers_.show(state_);
}

AssessedFrames CaptureLoop::Assess(const FrameSet& frame_set) {
  std::vector<std::future<DetectedFrame>> seen(frame_set.size());
  for (size_t c = 1; c < frame_set.size(); ++c)
    if (frame_set[c])
      seen[c] = std::async(std::launch::async, [this, c, &frame_set] {
        return cameras_[c].See(*frame_set[c]);
      });
  AssessedFrames assessed_frames(frame_set.size());
  for (size_t c = 0; c < frame_set.size(); ++c) {
    if (!frame_set[c]) continue;
    AssessedFrame& assessed = assessed_frames[c];
    assessed.frame = &*frame_set[c];
    assessed.seen = c == 0 ? cameras_[c].See(*frame_set[c]) : seen[c].get();
    const FrameStatus word =
        cameras_[c].Assess(assessed.seen, *rig_guide_->guide(c));
    assessed.word = GetStatusText(word);
    assessed.hint = GetRemedy(word);
  }
  return assessed_frames;
}

// Whether a frame set is to be kept, because a frame improves the estimate of
// its camera, or several frames that of the rig.
bool CaptureLoop::IsRequested(const AssessedFrames& assessed_frames) const {
  std::vector<const ImageFeatures*> usable(assessed_frames.size(), nullptr);
  for (size_t c = 0; c < assessed_frames.size(); ++c) {
    if (!assessed_frames[c].IsUsable()) continue;
    usable[c] = &assessed_frames[c].seen.features;
    const bool is_needed =
        assessed_frames.size() == 1 || !rig_guide_->guide(c)->is_done();
    if (assessed_frames[c].word == "kept" && is_needed) return true;
  }
  return rig_guide_->IsInformativeForLinks(usable);
}

void CaptureLoop::RejectWhileUnlocked(AssessedFrames* assessed_frames) {
  for (size_t c = 0; c < assessed_frames->size(); ++c) {
    AssessedFrame& assessed = (*assessed_frames)[c];
    if (!assessed.IsUsable()) continue;
    if (state_.is_paused) {
      assessed.word = "paused";
      continue;
    }
    const auto& kept = session_->cameras()[c].frames;
    FrameSource* const source =
        frames_->is_live() ? frames_->source(c) : nullptr;
    const std::string word = cameras_[c].GetStateText(
        *assessed.frame, source, kept.empty() ? nullptr : &kept.front());
    RecordLock(c);
    if (word == "refocused" || word == "cropped")
      assessed.hint =
          "the capture settings differ from those of the first frame: restore "
          "them with --control, or start a new session";
    if (!word.empty())
      assessed.word = word;
    else if (adjusting_.valid())
      assessed.word = "busy";
  }
}

void CaptureLoop::RecordLock(size_t camera) {
  const std::optional<StateLock> lock = cameras_[camera].TakeLock();
  if (!lock) return;
  session_->RecordLocked(camera, lock->locked, lock->open);
  const std::string start =
      cameras_.size() > 1 ? frames_->name(camera) + ": " : "";
  for (const std::string& text : lock->locked)
    lock_warnings_.push_back(start + "locked: " + text);
  for (const std::string& text : lock->open)
    lock_warnings_.push_back(start + "not locked: " + text);
}

void CaptureLoop::Save(AssessedFrames* assessed_frames) {
  std::string name;
  std::vector<FrameToSave> frames;
  std::vector<const GreyImage*> greys;
  std::vector<bool> changed(assessed_frames->size(), false);
  std::vector<ImageFeatures> images(assessed_frames->size());
  for (size_t c = 0; c < assessed_frames->size(); ++c) {
    AssessedFrame& assessed = (*assessed_frames)[c];
    if (!assessed.IsUsable()) continue;
    const LiveFrame& frame = *assessed.frame;
    if (name.empty()) name = session_->NewName(frame.name);
    assessed.seen.features.image = name;
    assessed.word = "kept";
    assessed.hint.clear();
    frames.push_back({c, frame.grey.size,
                      cameras_[c].MakeRecord(frame, assessed.seen),
                      frame.path.empty() ? EncodePng(frame.image)
                                         : ReadImageFile(frame.path)});
    greys.push_back(&frame.grey);
    images[c] = assessed.seen.features;
    changed[c] = true;
  }
  session_->Save(std::move(frames));
  state_.kept.push_back(name);
  if (viewers_.add_kept) viewers_.add_kept(name, greys);
  // With every_frame, frames arrive faster than the estimates can be updated.
  if (options_.frame_selector.every_frame) return;
  for (auto& avoided : avoided_) avoided.clear();
  has_failed_to_connect_ = false;
  UpdateCameras(changed,
                [images](size_t c, LiveCamera* live) { live->Add(images[c]); });
}

void CaptureLoop::Remove(const std::string& name) {
  auto& kept = state_.kept;
  const auto found = std::find(kept.begin(), kept.end(), name);
  if (found == kept.end()) return;
  kept.erase(found);
  std::vector<bool> changed;
  for (const Session& session : session_->cameras())
    changed.push_back(HasFrame(session, name));
  session_->Remove(name);
  UpdateCameras(changed,
                [name](size_t, LiveCamera* live) { live->Remove(name); });
}

void CaptureLoop::ApplyRequests() {
  std::vector<std::string> deleted;
  int num_undo = 0;
  {
    const std::lock_guard<std::mutex> lock(requests_->mutex_);
    deleted.swap(requests_->deleted_);
    std::swap(num_undo, requests_->num_undo_);
    state_.is_paused = requests_->is_paused_;
  }
  for (const std::string& name : deleted) Remove(name);
  for (; num_undo > 0 && !state_.kept.empty(); --num_undo)
    Remove(std::string(state_.kept.back()));
}

// ---- Display ---------------------------------------------------------------

void CaptureLoop::CountFrameSet() {
  constexpr size_t kMost = 30;
  taken_.push_back(SteadyClock::now());
  if (taken_.size() > kMost) taken_.erase(taken_.begin());
  if (taken_.size() > 1)
    state_.frames_per_second = static_cast<double>(taken_.size() - 1) /
                               std::max(1e-6, SecondsSince(taken_.front()));
}

void CaptureLoop::Describe(const AssessedFrames& assessed_frames) {
  state_.camera = frames_->name(shown_);
  state_.warnings = lock_warnings_;
  const AssessedFrame& assessed = assessed_frames[shown_];
  if (assessed.frame) DescribeFrame(assessed, &state_);
  DescribeKnown(*rig_guide_, shown_, &state_);
  if (assessed.frame)
    DescribeNext(*rig_guide_, assessed.seen.features, &state_);
  if (assessed.frame) RequestPattern(assessed.seen.features);
  if (assessed_frames.size() > 1)
    DescribeRig(*rig_guide_, *frames_, assessed_frames, shown_, &state_);
}

void CaptureLoop::RequestPattern(const ImageFeatures& seen) {
  constexpr int kManyFrames = 300;
  num_without_board_ = seen.features.empty() ? num_without_board_ + 1 : 0;
  if (num_without_board_ > kManyFrames && rig_guide_->next())
    state_.hint += "; does it match --pattern?";
}

}  // namespace raygrid
