#ifndef RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H
#define RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "adjustment/board_flex.h"
#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// A pattern point seen at a pixel.
struct Observation {
  int point = 0;
  Eigen::Vector2d pixel;
};

/// The view that one camera had of a board that stood at one of the poses, or
/// belonged to a body of several boards that stood there.
struct View {
  std::vector<Observation> observations;
  int camera = 0, pose = 0;
  int place = -1;  ///< of the board on the body; -1: its frame is the body's
  /// Of each of a stack's ranges: the value that its camera was at.
  std::vector<double> conditions;
};

/// A camera as it was for one view: a stack at the view's values, another
/// one as it always is. The camera must outlive it.
class SeeingCamera {
 public:
  SeeingCamera(const CameraModel& camera, const View& view);
  const CameraModel& operator*() const { return *camera_; }
  const CameraModel* operator->() const { return camera_; }

 private:
  std::unique_ptr<const CameraModel> own_;
  const CameraModel* camera_;
};

/// The unknowns of bundle adjustment. A single camera is a rig of one. Copies
/// are deep.
struct AdjustmentState {
  std::vector<std::unique_ptr<CameraModel>> cameras;
  std::vector<Pose> camera_from_rig;   ///< the first stays as it is
  std::vector<Pose> rig_from_pattern;  ///< shared by the cameras of an instant
  /// Where boards are on their bodies, by View::place.
  std::vector<Pose> body_from_board;
  std::vector<Eigen::Vector3d> points;  ///< in the board's frame
  FlexModes modes;                      ///< none: boards do not bend
  BendScope bend_scope = BendScope::kPose;
  /// Coefficients of each rig_from_pattern, or of each board.
  std::vector<FlexModes::Coefficients> flex;

  AdjustmentState() = default;
  AdjustmentState(AdjustmentState&&) = default;
  AdjustmentState& operator=(AdjustmentState&&) = default;
  AdjustmentState(const AdjustmentState& other) { *this = other; }
  AdjustmentState& operator=(const AdjustmentState& other);

  /// One camera, which is the rig.
  void SetCamera(const CameraModel& camera);
  const CameraModel& camera() const { return *cameras.front(); }

  Pose CameraFromPattern(const View& view) const;
  SeeingCamera CameraOf(const View& view) const {
    return SeeingCamera(*cameras[view.camera], view);
  }
  /// A point of a board that stands at a pose, as it is bent there.
  Eigen::Vector3d PointAt(int pose, int point) const {
    if (modes.count() == 0) return points[point];
    const int index =
        bend_scope == BendScope::kPose ? pose : modes.boards[point];
    return points[point] + modes.by_point[point] * flex[index];
  }
  /// Whether boards are bent, each alike in all views.
  bool HasShapes() const {
    return modes.count() > 0 && bend_scope == BendScope::kBoard;
  }
  /// Whether boards bend from view to view.
  bool HasFlex() const {
    return modes.count() > 0 && bend_scope == BendScope::kPose;
  }
  /// A point of a board as it is bent in all views.
  Eigen::Vector3d ShapedPoint(int point) const {
    return HasShapes() ? PointAt(0, point) : points[point];
  }
  /// The points take the shapes of their boards, which have no bends then.
  void KeepShapes();
  /// Boards take the bends of their points, from nominal ones, as their shapes.
  void TakeShapes(FlexModes flex_modes,
                  const std::vector<Eigen::Vector3d>& nominal);
  /// Lets boards bend, from no bend on.
  void SetModes(FlexModes flex_modes, BendScope scope);
  /// The first camera's frame becomes the rig's.
  void MoveRigToFirstCamera();
  int NumCameraParameters() const;  ///< of all cameras together
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H
