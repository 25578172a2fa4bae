/// Updates the intrinsics for each frame from a blob's operating-point model.
#ifndef RAYGRID_LIBCAMERA_OPERATING_POINT_FOLLOWER_H
#define RAYGRID_LIBCAMERA_OPERATING_POINT_FOLLOWER_H

#include <cstdint>
#include <optional>

#include "frame_source.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// Numbers of frames with an unknown or clamped operating point.
struct OperatingPointCounts {
  uint64_t num_missing = 0;  ///< no value in the metadata: keeps the last one
  uint64_t outside = 0;      ///< value out of range: clamped
};

/// Sets a camera's operating point from the metadata of each frame.
class OperatingPointFollower {
 public:
  /// The camera must outlive this object, and not be in use during updates.
  explicit OperatingPointFollower(rg_camera* camera);

  /// Whether the blob has no operating-point model.
  bool is_idle() const { return !condition_; }
  /// Updates from metadata. Throws CameraError if the model is corrupt.
  void Follow(const FrameInfo& info);
  /// Updates from a value; the blob must have an operating-point model.
  void FollowValue(double value);
  const OperatingPointCounts& counts() const { return counts_; }

 private:
  rg_camera* const camera_;
  std::optional<rg_operating_parameter> condition_;
  OperatingPointCounts counts_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_OPERATING_POINT_FOLLOWER_H
