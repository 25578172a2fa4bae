/// Converts a capture's frames and guidance to the state shown to users and
/// programs.
#ifndef RAYGRID_CAPTURE_CAPTURE_DESCRIPTION_H
#define RAYGRID_CAPTURE_CAPTURE_DESCRIPTION_H

#include <string>
#include <vector>

#include "capture/keyframe_selector.h"
#include "capture/rig_guide.h"
#include "capture_state.h"
#include "paired_frames.h"

namespace raygrid {

/// A camera's image of a frame, and its assessment.
struct AssessedFrame {
  const LiveFrame* frame = nullptr;  ///< NULL: no image
  DetectedFrame seen;
  std::string word, hint;

  /// Whether it is good enough to be kept together with others of its frame.
  bool IsUsable() const { return frame && (word == "kept" || word == "known"); }
};
using AssessedFrames = std::vector<AssessedFrame>;  ///< by camera

/// Sets the state of the image itself: status, size, features, sharpness,
/// brightness. judged.frame must not be NULL.
void DescribeFrame(const AssessedFrame& assessed, CaptureState* state);
/// Sets the camera's predicted uncertainty and the remaining images.
void DescribeKnown(const RigGuide& rig, size_t camera, CaptureState* state);
/// Sets the next view, and the direction to it from the current features, for
/// the camera that the view is for.
void DescribeNext(const RigGuide& rig, const ImageFeatures& features,
                  CaptureState* state);
/// Sets the summary of all cameras of a rig and their relative poses. shown:
/// camera described by the state.
void DescribeRig(const RigGuide& rig, const PairedFrames& frames,
                 const AssessedFrames& assessed, size_t shown,
                 CaptureState* state);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_DESCRIPTION_H
