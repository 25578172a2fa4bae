#include "paired_frames.h"

#include <algorithm>

#include "dataset/error.h"

namespace raygrid {

PairedFrames::PairedFrames(std::vector<CameraStream> cameras,
                           double tolerance_s)
    : cameras_(std::move(cameras)),
      tolerance_s_(tolerance_s),
      pending_(cameras_.size()),
      last_pair_(Clock::now()) {
  for (const CameraStream& camera : cameras_)
    if (camera.frames->is_live() != is_live() ||
        camera.frames->done().has_value() !=
            cameras_[0].frames->done().has_value())
      throw Error(
          ExitCode::kUsage,
          "--source: the sources of a rig must be all cameras, all videos or "
          "all folders, since frames are paired by time, number or name");
}

std::vector<std::string> PairedFrames::names() const {
  std::vector<std::string> names;
  for (const CameraStream& camera : cameras_) names.push_back(camera.camera);
  return names;
}

bool PairedFrames::is_finished() const {
  const auto is_finished = [](const CameraStream& camera) {
    return camera.frames->is_finished();
  };
  if (is_live())
    return std::any_of(cameras_.begin(), cameras_.end(), is_finished);
  return std::all_of(cameras_.begin(), cameras_.end(), is_finished) &&
         std::none_of(pending_.begin(), pending_.end(),
                      [](const auto& frame) { return frame.has_value(); });
}

std::optional<FrameSet> PairedFrames::Next() {
  if (size() > 1) return is_live() ? NextLive() : ReadNextFiles();
  auto frame = cameras_[0].frames->Next();
  if (!frame) return std::nullopt;
  FrameSet frame_set;
  frame_set.push_back(std::move(frame));
  return frame_set;
}

// Returns false if a camera has no frame.
bool PairedFrames::FillPending() {
  bool is_full = true;
  for (size_t c = 0; c < size(); ++c) {
    if (!pending_[c] && !cameras_[c].frames->is_finished())
      pending_[c] = cameras_[c].frames->Next();
    is_full &= pending_[c].has_value();
  }
  return is_full;
}

FrameSet PairedFrames::PopPending(const std::vector<bool>& taken) {
  FrameSet frame_set(size());
  for (size_t c = 0; c < size(); ++c)
    if (taken[c]) frame_set[c].swap(pending_[c]);
  return frame_set;
}

std::optional<FrameSet> PairedFrames::NextLive() {
  constexpr std::chrono::seconds kPatience(1);
  const bool is_full = FillPending();
  const auto now = Clock::now();
  const auto get_time = [&](size_t c) {
    return pending_[c]->info.timestamp_ns;
  };
  std::optional<size_t> oldest, newest;
  for (size_t c = 0; c < size(); ++c) {
    if (!pending_[c]) continue;
    if (!oldest || get_time(c) < get_time(*oldest)) oldest = c;
    if (!newest || get_time(c) > get_time(*newest)) newest = c;
  }
  if (!oldest) return std::nullopt;
  if (is_full &&
      static_cast<double>(get_time(*newest) - get_time(*oldest)) * 1e-9 <=
          tolerance_s_) {
    last_pair_ = now;
    is_unpaired_ = false;
    return PopPending(std::vector<bool>(size(), true));
  }
  // The matching frame is missing, or a camera is late.
  is_unpaired_ = now - last_pair_ > kPatience;
  if (!is_full && !is_unpaired_) return std::nullopt;
  std::vector<bool> taken(size(), false);
  taken[*oldest] = true;
  FrameSet alone = PopPending(taken);
  return is_unpaired_ ? std::optional(std::move(alone)) : std::nullopt;
}

std::optional<FrameSet> PairedFrames::ReadNextFiles() {
  FillPending();
  for (size_t c = 0; c < size(); ++c)
    if (!pending_[c] && !cameras_[c].frames->is_finished())
      return std::nullopt;  // the other frame is still to come
  std::vector<bool> taken(size(), false);
  const std::string* first = nullptr;  // name; empty for videos
  for (const auto& frame : pending_)
    if (frame && (!first || frame->name < *first)) first = &frame->name;
  if (!first) return std::nullopt;
  for (size_t c = 0; c < size(); ++c)
    taken[c] = pending_[c] && pending_[c]->name == *first;
  return PopPending(taken);
}

}  // namespace raygrid
