#include "capture_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "camera_error.h"
#include "camera_session.h"
#include "capture/board_outline.h"
#include "capture/board_view.h"
#include "capture/view_hint.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

using SteadyClock = std::chrono::steady_clock;

double SecondsSince(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

// The outline of a board, and its first row's side by itself.
ViewShown ShowView(const CameraModel& camera, const Board& board,
                   const Pose& camera_from_board) {
  ViewShown shown;
  shown.outline = OutlineOf(camera, board, camera_from_board);
  if (!shown.outline.empty())
    shown.top.assign(shown.outline.begin(),
                     shown.outline.begin() + kOutlineSteps + 1);
  return shown;
}

// The board of the pattern with most features in an image; NULL without any.
const Board* LargestBoard(const Pattern& pattern, const ImageFeatures& image) {
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

std::optional<double> Told(double value) {
  return value > 0 ? std::optional(value) : std::nullopt;
}

// How the camera stood.
SessionFrame StateOf(const FrameInfo& info) {
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

// The word on a frame that shows another camera than the first one kept: its
// lens has moved, or another part of the sensor is shown. NULL: the same.
const char* WordOfOtherState(const SessionFrame& first,
                             const SessionFrame& now) {
  const bool has_lens_moved =
      first.lens_position && now.lens_position &&
      std::abs(*first.lens_position - *now.lens_position) >
          kDefaultLensTolerance;
  if (has_lens_moved || first.focus_steps != now.focus_steps)
    return "refocused";
  return first.crop != now.crop || first.zoom != now.zoom ? "cropped" : nullptr;
}

SessionFrame RecordOf(const LiveFrame& frame, const SeenFrame& seen,
                      double variance_taken) {
  SessionFrame record = StateOf(frame.info);
  record.image = seen.features.image;
  record.seconds = frame.time_s;
  record.edge_spread_px = Told(seen.quality.most_spread_px);
  record.white = Told(seen.quality.white);
  record.variance_taken = variance_taken;
  return record;
}

}  // namespace

void CaptureWishes::Pause(bool is_paused) {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_paused_ = is_paused;
}

void CaptureWishes::Finish() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_finished_ = true;
}

void CaptureWishes::Undo() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++num_undo_;
}

void CaptureWishes::Delete(const std::string& name) {
  const std::lock_guard<std::mutex> lock(mutex_);
  deleted_.push_back(name);
}

CaptureLoop::CaptureLoop(const CaptureLoopOptions& options,
                         const Pattern& pattern, LiveFrames* frames,
                         SessionFolder* session, CaptureViewers viewers,
                         CaptureWishes* wishes)
    : options_(options),
      pattern_(pattern),
      frames_(frames),
      session_(session),
      viewers_(std::move(viewers)),
      wishes_(wishes),
      detector_(pattern, {}),
      judge_(options.judge) {
  for (const Board& board : pattern.boards)
    meters_.emplace(board.id, QualityMeter(board));
  state_.target_px = options.guide.target_px;
}

CaptureLoop::~CaptureLoop() {
  if (adjusting_.valid()) adjusting_.wait();
}

void CaptureLoop::Run() {
  auto last = SteadyClock::now();
  while (!IsFinished()) {
    FollowWishes();
    TakeGuide(false);
    if (const auto frame = frames_->Next()) {
      has_seen_frames_ = true;
      TakeFrame(*frame);
      last = SteadyClock::now();
    } else if (frames_->is_live() && !frames_->is_finished() &&
               SecondsSince(last) > options_.timeout_s) {
      throw CameraError(CameraExit::kInput,
                        "the source gives no frames; connect it again and go "
                        "on with --resume, or allow more with --timeout");
    }
  }
  if (!has_seen_frames_ && frames_->is_finished() && !IsSignalled())
    throw InputError(options_.source + ": has no frame that can be read");
  FollowWishes();
  TakeGuide(true);
  if (!guide_) return;
  state_.is_done = guide_->is_done();
  if (!state_.kept.empty()) state_.hint = state_.is_done ? "done" : "finished";
  DescribeKnown();
  if (viewers_.show) viewers_.show(state_);
}

bool CaptureLoop::IsFinished() {
  if (IsSignalled() || frames_->is_finished()) return true;
  const std::lock_guard<std::mutex> lock(wishes_->mutex_);
  return wishes_->is_finished_ || (guide_ && guide_->is_done());
}

// ---- The camera so far ------------------------------------------------------

void CaptureLoop::UpdateCamera(Update update) {
  TakeGuide(true);
  adjusting_ =
      std::async(std::launch::async, [this, update, options = options_.guide] {
        update(live_.get());
        return std::make_unique<CaptureGuide>(*live_, pattern_, options);
      });
  if (!frames_->is_live()) TakeGuide(true);
}

void CaptureLoop::TakeGuide(bool wait) {
  if (!adjusting_.valid()) return;
  if (!wait &&
      adjusting_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return;
  guide_ = adjusting_.get();
  guided_since_ = SteadyClock::now();
}

// Some views cannot be shown: the board does not fit there, or is not found.
void CaptureLoop::LeaveViewInVain() {
  constexpr double kPatienceS = 20;
  if (!frames_->is_live() || adjusting_.valid() || state_.is_paused ||
      !guide_->knowledge() || !guide_->next() ||
      SecondsSince(guided_since_) < kPatienceS)
    return;
  options_.guide.avoided.push_back(guide_->next()->camera_from_board);
  UpdateCamera([](LiveCamera*) {});
}

// The frames of the session so far, which are looked at anew.
void CaptureLoop::Resume() {
  std::vector<ImageFeatures> images;
  for (const SessionFrame& frame : session_->session().frames) {
    const GreyImage grey =
        MakeGreyImage(ReadGreyLevels(session_->PathOf(frame.image)));
    if (viewers_.add_kept) viewers_.add_kept(frame.image, grey);
    state_.kept.push_back(frame.image);
    images.push_back({frame.image, detector_.Detect(grey).features});
  }
  UpdateCamera([images](LiveCamera* live) { live->Add(images); });
  TakeGuide(true);
}

// ---- Frames -----------------------------------------------------------------

SeenFrame CaptureLoop::See(const LiveFrame& frame) const {
  SeenFrame seen;
  seen.features.features = detector_.Detect(frame.grey).features;
  seen.time_s = frame.time_s;
  if (frame.info.exposure_us) seen.exposure_s = *frame.info.exposure_us * 1e-6;
  if (const Board* const board = LargestBoard(pattern_, seen.features)) {
    std::vector<Feature> own;
    for (const Feature& feature : seen.features.features)
      if (feature.board == board->id) own.push_back(feature);
    seen.quality =
        meters_.at(board->id).Measure(frame.grey.size, frame.grey.levels, own);
  }
  return seen;
}

void CaptureLoop::TakeFrame(const LiveFrame& frame) {
  if (!live_) {
    live_ = std::make_unique<LiveCamera>(pattern_, frame.grey.size,
                                         options_.num_threads);
    if (!session_->session().frames.empty()) {
      const ImageSize size = session_->session().image_size;
      if (size != frame.grey.size)
        throw Error(ExitCode::kUsage,
                    fmt::format("the session's frames have {} x {} pixels, the "
                                "source's {} x {}; choose the same --size",
                                size.width, size.height, frame.grey.size.width,
                                frame.grey.size.height));
      Resume();
    }
    if (!guide_)
      guide_ = std::make_unique<CaptureGuide>(*live_, pattern_, options_.guide);
  }
  SeenFrame seen = See(frame);
  if (IsKept(frame, seen)) {
    seen.features.image = session_->NewName(frame.name);
    Keep(frame, seen);
  }
  CountFrame();
  LeaveViewInVain();
  Describe(frame, seen);
  if (viewers_.show_picture) viewers_.show_picture(frame.grey);
  if (viewers_.show) viewers_.show(state_);
}

// Says the word on a frame, too.
bool CaptureLoop::IsKept(const LiveFrame& frame, const SeenFrame& seen) {
  const FrameWord word = judge_.Judge(seen, *guide_);
  state_.word = WordOf(word);
  state_.hint = RemedyOf(word);
  if (word != FrameWord::kKept) return false;
  const auto& kept = session_->session().frames;
  const char* const other =
      kept.empty() ? nullptr
                   : WordOfOtherState(kept.front(), StateOf(frame.info));
  if (state_.is_paused) {
    state_.word = "paused";
  } else if (IsLocking(frame)) {
    state_.word = "locking";
  } else if (other) {
    state_.word = other;
    state_.hint =
        "the camera stands otherwise than in the first frame: begin "
        "anew, or set it back with --control";
  } else if (adjusting_.valid()) {
    state_.word = "busy";
  }
  return state_.word == "kept";
}

void CaptureLoop::Keep(const LiveFrame& frame, const SeenFrame& seen) {
  session_->Keep(
      frame.grey.size, RecordOf(frame, seen, judge_.gain()),
      frame.path.empty() ? EncodePng(frame.image) : ReadImageFile(frame.path));
  state_.kept.push_back(seen.features.image);
  if (viewers_.add_kept) viewers_.add_kept(seen.features.image, frame.grey);
  options_.guide.avoided.clear();
  UpdateCamera([image = seen.features](LiveCamera* live) { live->Add(image); });
}

// Once a frame is good enough to be kept, the camera is to stay so. Frames that
// arrived before, or just behind, may not tell yet how it stands: V4L2 is asked
// once a second.
bool CaptureLoop::IsLocking(const LiveFrame& frame) {
  constexpr std::chrono::milliseconds kSettlingTime(1200);
  if (!lock_time_) LockCamera();
  return is_locked_ && frame.arrived < *lock_time_ + kSettlingTime;
}

void CaptureLoop::LockCamera() {
  lock_time_ = SteadyClock::now();
  FrameSource* const source = frames_->source();
  if (!source || !frames_->is_live()) return;
  const StateLock lock = source->LockState();
  is_locked_ = !lock.locked.empty();
  session_->NoteLocked(lock.locked, lock.open);
  for (const std::string& text : lock.locked)
    state_.remarks.push_back("locked: " + text);
  for (const std::string& text : lock.open)
    state_.remarks.push_back("not locked: " + text);
}

void CaptureLoop::Remove(const std::string& name) {
  auto& kept = state_.kept;
  const auto found = std::find(kept.begin(), kept.end(), name);
  if (found == kept.end()) return;
  kept.erase(found);
  session_->Remove(name);
  UpdateCamera([name](LiveCamera* live) { live->Remove(name); });
}

void CaptureLoop::FollowWishes() {
  std::vector<std::string> deleted;
  int num_undo = 0;
  {
    const std::lock_guard<std::mutex> lock(wishes_->mutex_);
    deleted.swap(wishes_->deleted_);
    std::swap(num_undo, wishes_->num_undo_);
    state_.is_paused = wishes_->is_paused_;
  }
  for (const std::string& name : deleted) Remove(name);
  for (; num_undo > 0 && !state_.kept.empty(); --num_undo)
    Remove(std::string(state_.kept.back()));
}

// ---- What is shown ----------------------------------------------------------

void CaptureLoop::CountFrame() {
  constexpr size_t kMost = 30;
  taken_.push_back(SteadyClock::now());
  if (taken_.size() > kMost) taken_.erase(taken_.begin());
  if (taken_.size() > 1)
    state_.frames_per_second = static_cast<double>(taken_.size() - 1) /
                               std::max(1e-6, SecondsSince(taken_.front()));
}

void CaptureLoop::Describe(const LiveFrame& frame, const SeenFrame& seen) {
  state_.width = frame.grey.size.width;
  state_.height = frame.grey.size.height;
  state_.features.clear();
  for (const Feature& feature : seen.features.features)
    state_.features.push_back(feature.pixel);
  state_.sharpness_px = seen.quality.most_spread_px;
  state_.brightness = seen.quality.white / 255;
  DescribeKnown();
  DescribeNext(seen);
}

void CaptureLoop::DescribeKnown() {
  state_.places.clear();
  state_.deviation_px = 0;
  if (const CameraKnowledge* const knowledge = guide_->knowledge()) {
    state_.deviation_px = knowledge->Percentile95Px();
    for (const KnownPlace& place : knowledge->places())
      state_.places.push_back({place.pixel, place.deviation_px});
  }
  state_.is_done = guide_->is_done();
  state_.num_expected = guide_->num_expected().value_or(-1);
}

void CaptureLoop::DescribeNext(const SeenFrame& seen) {
  state_.next.clear();
  state_.arrow.clear();
  if (guide_->is_done()) {
    state_.hint = "done";
    return;
  }
  const auto& next = guide_->next();
  if (!next) return;
  const CameraModel& camera = guide_->camera();
  state_.next.push_back(
      ShowView(camera, *next->board, next->camera_from_board));
  for (const LocatedBoard& located : guide_->Locate(seen.features)) {
    if (located.board->id != next->board->id) continue;
    const Eigen::Vector3d middle = MiddleOf(*located.board);
    const auto from = camera.Project(located.camera_from_board * middle);
    const auto to = camera.Project(next->camera_from_board * middle);
    if (from && to) state_.arrow = {*from, *to};
    if (state_.hint.empty())
      state_.hint =
          DescribeMove(camera, *next->board, located.camera_from_board,
                       next->camera_from_board);
  }
  if (state_.hint.empty()) state_.hint = "fill the outline with the board";
  constexpr int kManyFrames = 300;
  num_without_board_ =
      seen.features.features.empty() ? num_without_board_ + 1 : 0;
  if (num_without_board_ > kManyFrames)
    state_.hint += "; is it the one that --pattern says?";
}

}  // namespace raygrid
