#ifndef RAYGRID_SHUTTER_BOARD_TRACKS_H
#define RAYGRID_SHUTTER_BOARD_TRACKS_H

#include <Eigen/Core>
#include <vector>

#include "shutter/frame_motion.h"
#include "shutter/line_delay.h"

namespace raygrid {

/// A target point and its observation.
struct TrackPoint {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
  Eigen::Vector2d place;          ///< board position, longer side: -1 to 1
  size_t image = 0, feature = 0;  ///< in the dataset
};

/// The views of one board in consecutive frames, ordered by time.
struct BoardTrack {
  std::vector<double> times_s;
  std::vector<Pose> poses;  ///< camera_from_board at the central row
  std::vector<std::vector<TrackPoint>> points;
  std::vector<MotionStencil> stencils;
  double half_m = 0;  ///< half of the board's longer side
};

/// Makes the tracks of all boards. Of frames with equal time, only one is used.
std::vector<BoardTrack> MakeTracks(const MovingViews& views);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_BOARD_TRACKS_H
