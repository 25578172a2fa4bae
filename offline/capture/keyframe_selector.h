#ifndef RAYGRID_CAPTURE_KEYFRAME_SELECTOR_H
#define RAYGRID_CAPTURE_KEYFRAME_SELECTOR_H

#include <deque>
#include <optional>

#include "capture/capture_guide.h"
#include "capture/frame_quality.h"

namespace raygrid {

/// Reasons to keep or reject a frame.
enum class FrameStatus {
  kKept,
  kAbsent,   ///< no board detected
  kFew,      ///< too few features of a board
  kDark,     ///< too little contrast
  kBright,   ///< white is saturated, which displaces edges
  kMoving,   ///< features move during the exposure
  kBlurred,  ///< edges are more blurred than in other frames
             ///< of this camera
  kKnown     ///< too little gain
};

/// Returns the displayed text.
const char* GetStatusText(FrameStatus word);
/// Returns a short remedy; "" if there is none.
const char* GetRemedy(FrameStatus word);

/// A frame with its detected boards.
struct DetectedFrame {
  ImageFeatures features;
  FrameQuality quality;          ///< quality of the board with most features
  std::optional<double> time_s;  ///< time in the video; nullopt: a photograph
  std::optional<double> exposure_s;
};

struct KeyframeSelectorOptions {
  /// Maximum RMS motion of the features (px) for a frame to count as still:
  /// since the last frame (or in 1/30 s, if that is longer ago), and during the
  /// exposure.
  double still_px = 0.3;
  /// Keeps all frames of a moving camera: frames need not be still, sharp or
  /// informative.
  bool every_frame = false;
};

/// Decides which frames to keep, in the order of capture.
class KeyframeSelector {
 public:
  explicit KeyframeSelector(const KeyframeSelectorOptions& options)
      : options_(options) {}

  FrameStatus Assess(const DetectedFrame& frame, const CaptureGuide& guide);
  /// Returns the gain of the last frame; 0 if rejected for another reason.
  double gain() const { return gain_; }

 private:
  bool IsMoving(const DetectedFrame& frame,
                const FeaturePositions& places) const;
  bool IsBlurred(const FrameQuality& quality);

  KeyframeSelectorOptions options_;
  FeaturePositions last_positions_;
  std::optional<double> last_time_s_;
  std::deque<double> spreads_px_;  // edge widths of recent frames
  double gain_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_KEYFRAME_SELECTOR_H
