#ifndef RAYGRID_CAPTURE_VIEW_HINT_H
#define RAYGRID_CAPTURE_VIEW_HINT_H

#include <string>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/pattern.h"

namespace raygrid {

/// Describes the motion of a board from one pose (camera_from_board) to
/// another, in terms of the image: "closer, tilt the top away". At most three
/// motions, largest first; "hold it there" if all are negligible.
std::string DescribeMove(const CameraModel& camera, const Board& board,
                         const Pose& from, const Pose& to);

/// Returns whether the motion between two poses is negligible.
bool HasReachedView(const CameraModel& camera, const Board& board,
                    const Pose& from, const Pose& to);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_VIEW_HINT_H
