#include "capture/keyframe_selector.h"

#include <algorithm>
#include <cmath>

#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr size_t kMinFeatures = 12;

struct StatusText {
  const char* word;
  const char* remedy;
};

// Indexed by FrameStatus.
constexpr StatusText kStatusTexts[] = {
    {"kept", ""},
    {"absent", "show the board"},
    {"few", "show more of the board"},
    {"dark", "add light, or increase the exposure time"},
    {"bright", "reduce light, or the exposure time"},
    {"moving", "hold the board still"},
    {"blurred", "focus, or move the board into focus"},
    {"known", ""}};

bool IsTooDark(const FrameQuality& quality) {
  constexpr double kMinContrast = 30;
  return quality.white > 0 && quality.white - quality.black < kMinContrast;
}

bool IsTooBright(const FrameQuality& quality) {
  constexpr double kMaxClippedFraction = 0.3;
  return quality.clipped > kMaxClippedFraction;
}

}  // namespace

const char* GetStatusText(FrameStatus word) {
  return kStatusTexts[static_cast<int>(word)].word;
}

const char* GetRemedy(FrameStatus word) {
  return kStatusTexts[static_cast<int>(word)].remedy;
}

bool KeyframeSelector::IsMoving(const DetectedFrame& frame,
                                const FeaturePositions& places) const {
  // Motion blurs only edges perpendicular to it.
  const FrameQuality& quality = frame.quality;
  const double streak_px =
      std::sqrt(std::max(0.0, std::pow(quality.max_spread_px, 2) -
                                  std::pow(quality.min_spread_px, 2)));
  constexpr double kMaxStreakPx = 1;
  if (streak_px > kMaxStreakPx) return true;
  if (!frame.time_s || !last_time_s_) return false;
  const auto moved_px = DistancePx(places, last_positions_);
  if (!moved_px) return true;  // the target was not visible before
  const double elapsed_s = *frame.time_s - *last_time_s_;
  if (!(elapsed_s > 0)) return *moved_px > options_.still_px;
  constexpr double kFrameS = 1 / 30.0;
  double shown_s = std::min(elapsed_s, kFrameS);
  if (frame.exposure_s) shown_s = std::min(shown_s, *frame.exposure_s);
  return *moved_px / elapsed_s * shown_s > options_.still_px;
}

bool KeyframeSelector::IsBlurred(const FrameQuality& quality) {
  if (!(quality.max_spread_px > 0)) return false;
  constexpr size_t kMaxFrames = 500;
  constexpr double kSharpPx = 1.2;  // smaller spreads are never blurred
  constexpr double kMaxSharpnessRatio =
      1.5;                      // relative to the camera's sharp frames
  constexpr double kAnyPx = 5;  // larger spreads are always blurred
  spreads_px_.push_back(quality.max_spread_px);
  if (spreads_px_.size() > kMaxFrames) spreads_px_.pop_front();
  const double sharp_px =
      Quantile({spreads_px_.begin(), spreads_px_.end()}, 0.1);
  return quality.max_spread_px >
         std::min(kAnyPx, std::max(kSharpPx, kMaxSharpnessRatio * sharp_px));
}

FrameStatus KeyframeSelector::Assess(const DetectedFrame& frame,
                                     const CaptureGuide& guide) {
  gain_ = 0;
  FeaturePositions places = CollectFeaturePositions(frame.features);
  const bool is_moving = IsMoving(frame, places);
  last_positions_ = std::move(places);
  last_time_s_ = frame.time_s;
  const size_t count = frame.features.features.size();
  if (count == 0) return FrameStatus::kAbsent;
  if (count < kMinFeatures) return FrameStatus::kFew;
  if (IsTooDark(frame.quality)) return FrameStatus::kDark;
  if (IsTooBright(frame.quality)) return FrameStatus::kBright;
  if (options_.every_frame) return FrameStatus::kKept;
  if (is_moving) return FrameStatus::kMoving;
  if (IsBlurred(frame.quality)) return FrameStatus::kBlurred;
  gain_ = guide.ComputeGain(frame.features);
  return guide.ShouldKeep(gain_, guide.IsNextView(frame.features))
             ? FrameStatus::kKept
             : FrameStatus::kKnown;
}

}  // namespace raygrid
