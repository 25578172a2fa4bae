#ifndef RAYGRID_SHUTTER_BOARD_TRACKS_H
#define RAYGRID_SHUTTER_BOARD_TRACKS_H

#include <Eigen/Core>
#include <vector>

#include "shutter/frame_motion.h"
#include "shutter/row_time.h"

namespace raygrid {

/// A board's point and the pixel that shows it.
struct TrackPoint {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
  Eigen::Vector2d place;  ///< on the board, whose longer side is -1 to 1
  size_t image = 0, feature = 0;  ///< in the dataset
};

/// A board in the frames that show it, in the order of time.
struct BoardTrack {
  std::vector<double> times_s;
  std::vector<Pose> poses;  ///< camera_from_board when the middle row is read
  std::vector<std::vector<TrackPoint>> points;
  std::vector<MotionStencil> stencils;
  double half_m = 0;  ///< half of the board's longer side
};

/// The tracks of all boards. Frames of one time count once.
std::vector<BoardTrack> MakeTracks(const MovingViews& views);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_BOARD_TRACKS_H
