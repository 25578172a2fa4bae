#ifndef RAYGRID_CAPTURE_FRAME_JUDGE_H
#define RAYGRID_CAPTURE_FRAME_JUDGE_H

#include <deque>
#include <optional>

#include "capture/capture_guide.h"
#include "capture/frame_quality.h"

namespace raygrid {

/// Why a frame is kept or not.
enum class FrameWord {
  kKept,
  kAbsent,   ///< no board is seen
  kFew,      ///< too few features of one
  kDark,     ///< black and white hardly differ
  kBright,   ///< white is as white as can be: its edges are not where they were
  kMoving,   ///< features move within the frame's exposure
  kBlurred,  ///< edges are spread more than this camera's other frames have
             ///< them
  kKnown     ///< it would add little
};

/// One word, as people see it.
const char* WordOf(FrameWord word);
/// The remedy in half a sentence; "" where nothing is to be mended.
const char* RemedyOf(FrameWord word);

/// A frame in which boards were sought.
struct SeenFrame {
  ImageFeatures features;
  FrameQuality quality;          ///< of the board with most features
  std::optional<double> time_s;  ///< of the video; none: a photograph
  std::optional<double> exposure_s;
};

struct JudgeOptions {
  /// A frame is still if its features moved by less, RMS, since the last one
  /// (longer ago than 1/30 s: in that time), or within its exposure.
  double still_px = 0.3;
  /// Frames of a moving camera are kept one after the other: they need not be
  /// still, sharp or new.
  bool every_frame = false;
};

/// Judges frames in the order in which they came.
class FrameJudge {
 public:
  explicit FrameJudge(const JudgeOptions& options) : options_(options) {}

  FrameWord Judge(const SeenFrame& frame, const CaptureGuide& guide);
  /// The part of the mean variance that the last frame would have taken away;
  /// 0 if something else was wrong with it.
  double gain() const { return gain_; }

 private:
  bool IsMoving(const SeenFrame& frame, const FeaturePlaces& places) const;
  bool IsBlurred(const FrameQuality& quality);

  JudgeOptions options_;
  FeaturePlaces last_places_;
  std::optional<double> last_time_s_;
  std::deque<double> spreads_px_;  // of the newest frames
  double gain_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_FRAME_JUDGE_H
