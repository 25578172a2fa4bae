/// Whether the times of frames fit the motion that the frames show.
#ifndef RAYGRID_SHUTTER_TIME_CHECK_H
#define RAYGRID_SHUTTER_TIME_CHECK_H

#include <string>
#include <vector>

#include "camera/pose.h"
#include "shutter/frame_motion.h"

namespace raygrid {

/// A frame with a time stamp, and where it shows a board.
struct TimedPose {
  std::string image;
  double time_s = 0;
  Pose pose;             ///< camera_from_board
  Matrix6d information;  ///< on UpdatedPose()'s update, for noise of 1 px
};

/// The frames that show a board, in the order of their times.
using TimedTrack = std::vector<TimedPose>;

/// Why the time stamps are not those of the motion, which is smooth between
/// frames; empty if they may be. Times that all differ by one factor always
/// fit.
std::string FindWrongTimes(const std::vector<TimedTrack>& tracks,
                           double noise_variance_px2);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_TIME_CHECK_H
