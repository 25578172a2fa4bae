/// Checks whether frame times are consistent with the motion in the images.
#ifndef RAYGRID_SHUTTER_TIMESTAMP_CHECK_H
#define RAYGRID_SHUTTER_TIMESTAMP_CHECK_H

#include <string>
#include <vector>

#include "camera/pose.h"
#include "shutter/frame_motion.h"

namespace raygrid {

/// The timestamp of a frame and the pose of a board in it.
struct TimedPose {
  std::string image;
  double time_s = 0;
  Pose pose;             ///< camera_from_board
  Matrix6d information;  ///< for UpdatedPose(), with noise of 1 px
};

/// The frames in which a board is visible, ordered by time.
using TimedTrack = std::vector<TimedPose>;

/// Returns why the timestamps contradict the motion, which is assumed to be
/// smooth between frames; empty if they are consistent. A common scale of all
/// times is not detected.
std::string CheckTimestamps(const std::vector<TimedTrack>& tracks,
                            double noise_variance_px2);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_TIMESTAMP_CHECK_H
