/// A blob's stack of cameras that follows the frames.
#ifndef RAYGRID_LIBCAMERA_STACK_FOLLOWER_H
#define RAYGRID_LIBCAMERA_STACK_FOLLOWER_H

#include <cstdint>
#include <optional>

#include "frame_source.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// How many frames a stack could not follow as it should.
struct StackCounts {
  uint64_t untold = 0;   ///< frames without a value: the last one stays
  uint64_t outside = 0;  ///< frames beyond the range: its end is taken
};

/// Makes a camera that of each frame's lens position, or temperature.
class StackFollower {
 public:
  /// The camera must outlive it, and not be in use while it follows.
  explicit StackFollower(rg_camera* camera);

  /// The blob has no stack: nothing is followed.
  bool is_idle() const { return !condition_; }
  /// Throws CameraError where the stack is damaged.
  void Follow(const FrameInfo& info);
  /// The like for a value of the condition; there is a stack.
  void FollowValue(double value);
  const StackCounts& counts() const { return counts_; }

 private:
  rg_camera* const camera_;
  std::optional<rg_condition> condition_;
  StackCounts counts_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STACK_FOLLOWER_H
