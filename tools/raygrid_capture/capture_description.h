/// The state of a capture as people and programs see it: from its frames and
/// its guidance.
#ifndef RAYGRID_CAPTURE_CAPTURE_DESCRIPTION_H
#define RAYGRID_CAPTURE_CAPTURE_DESCRIPTION_H

#include <string>
#include <vector>

#include "capture/frame_assessor.h"
#include "capture/rig_guide.h"
#include "capture_state.h"
#include "paired_frames.h"

namespace raygrid {

/// A camera's frame of an instant, and the word on it.
struct AssessedFrame {
  const LiveFrame* frame = nullptr;  ///< NULL: the camera has none
  DetectedFrame seen;
  std::string word, hint;

  /// Good enough to be kept with others of its instant.
  bool IsUsable() const { return frame && (word == "kept" || word == "known"); }
};
using AssessedFrames = std::vector<AssessedFrame>;  ///< by camera

/// The frame itself: word, size, features, sharpness, brightness. It must be
/// there.
void DescribeFrame(const AssessedFrame& judged, CaptureState* state);
/// How well a camera is known, and what is left to do.
void DescribeKnown(const RigGuide& rig, size_t camera, CaptureState* state);
/// The next view, and the way there from where the features are, which its
/// camera sees.
void DescribeNext(const RigGuide& rig, const ImageFeatures& features,
                  CaptureState* state);
/// All cameras of a rig in short, and how they stand to each other. shown is
/// the camera that the state tells of.
void DescribeRig(const RigGuide& rig, const PairedFrames& frames,
                 const AssessedFrames& judged, size_t shown,
                 CaptureState* state);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_DESCRIPTION_H
