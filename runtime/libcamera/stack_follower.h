/// Updates the intrinsics for each frame by a blob's operating-point model.
#ifndef RAYGRID_LIBCAMERA_STACK_FOLLOWER_H
#define RAYGRID_LIBCAMERA_STACK_FOLLOWER_H

#include <cstdint>
#include <optional>

#include "frame_source.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// The number of frames with an unknown or clamped operating point.
struct StackCounts {
  uint64_t untold = 0;   ///< no value in metadata: keeps the last one
  uint64_t outside = 0;  ///< outside the range: clamped
};

/// Sets a camera to each frame's lens position or temperature.
class StackFollower {
 public:
  /// The camera must outlive it, and must not be in use during updates.
  explicit StackFollower(rg_camera* camera);

  /// Whether the blob has no operating-point model.
  bool is_idle() const { return !condition_; }
  /// Throws CameraError if the model is corrupt.
  void Follow(const FrameInfo& info);
  /// The same for a value of the condition; the blob must have a model.
  void FollowValue(double value);
  const StackCounts& counts() const { return counts_; }

 private:
  rg_camera* const camera_;
  std::optional<rg_condition> condition_;
  StackCounts counts_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STACK_FOLLOWER_H
