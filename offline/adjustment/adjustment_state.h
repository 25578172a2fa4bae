#ifndef RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H
#define RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "adjustment/deformation_modes.h"
#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// An observation of a target point at a pixel.
struct Observation {
  int point = 0;
  Eigen::Vector2d pixel;
};

/// One camera's view of a board, which has a separate pose or belongs to a
/// rigid multi-board target.
struct View {
  std::vector<Observation> observations;
  int camera = 0, pose = 0;
  int place = -1;  ///< index of the board in target_from_board; -1: identity
  /// The camera's operating point: one value per axis of the model.
  std::vector<double> conditions;
};

/// The camera model of one view: an operating-point model evaluated at the
/// conditions of the view, or the unchanged camera. The camera must outlive
/// this object.
class CameraAtView {
 public:
  CameraAtView(const CameraModel& camera, const View& view);
  const CameraModel& operator*() const { return *camera_; }
  const CameraModel* operator->() const { return camera_; }

 private:
  std::unique_ptr<const CameraModel> owned_model_;
  const CameraModel* camera_;
};

/// The variables of bundle adjustment. A single camera is a rig of one. Copies
/// are deep.
struct AdjustmentState {
  std::vector<std::unique_ptr<CameraModel>> cameras;
  std::vector<Pose> camera_from_rig;   ///< the first is constant: the gauge
  std::vector<Pose> rig_from_pattern;  ///< shared by the cameras of a frame
  /// B_b: poses of boards in their rigid multi-board target, by View::place.
  std::vector<Pose> target_from_board;
  std::vector<Eigen::Vector3d> points;  ///< p_j, in the board's frame (m)
  DeformationModes modes;               ///< M; empty: no deformation
  DeformationScope deformation_scope = DeformationScope::kPose;
  /// Deformation coefficients (m), for each rig_from_pattern or each board.
  std::vector<DeformationModes::Coefficients> flex;

  AdjustmentState() = default;
  AdjustmentState(AdjustmentState&&) = default;
  AdjustmentState& operator=(AdjustmentState&&) = default;
  AdjustmentState(const AdjustmentState& other) { *this = other; }
  AdjustmentState& operator=(const AdjustmentState& other);

  /// Sets the only camera of a rig of one.
  void SetCamera(const CameraModel& camera);
  const CameraModel& camera() const { return *cameras.front(); }

  Pose ComputeCameraFromPattern(const View& view) const;
  CameraAtView GetCamera(const View& view) const {
    return CameraAtView(*cameras[view.camera], view);
  }
  /// Returns target point p_j + M_j f (m) for the deformation f of a pose.
  Eigen::Vector3d PointAt(int pose, int point) const {
    if (modes.count() == 0) return points[point];
    const int index = deformation_scope == DeformationScope::kPose
                          ? pose
                          : modes.boards[point];
    return points[point] + modes.by_point[point] * flex[index];
  }
  /// Returns whether a static deformation of the boards is estimated.
  bool HasStaticDeformation() const {
    return modes.count() > 0 && deformation_scope == DeformationScope::kBoard;
  }
  /// Returns whether a per-view deformation of the boards is estimated.
  bool HasPerViewDeformation() const {
    return modes.count() > 0 && deformation_scope == DeformationScope::kPose;
  }
  /// Returns a target point with the static deformation (m).
  Eigen::Vector3d DeformedPoint(int point) const {
    return HasStaticDeformation() ? PointAt(0, point) : points[point];
  }
  /// Moves the static deformation into the points, and removes the modes.
  void ApplyStaticDeformation();
  /// Converts the deviation of the points from nominal to static deformation.
  void FitStaticDeformation(DeformationModes deformation_modes,
                            const std::vector<Eigen::Vector3d>& nominal);
  /// Enables deformation modes, with zero coefficients.
  void SetModes(DeformationModes deformation_modes, DeformationScope scope);
  /// Makes the first camera's frame the rig frame.
  void MoveRigToFirstCamera();
  int NumCameraParameters() const;  ///< total over all cameras
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H
