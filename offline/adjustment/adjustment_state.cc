#include "adjustment/adjustment_state.h"

#include <utility>

#include "camera/operating_point_grid.h"

namespace raygrid {

CameraAtView::CameraAtView(const CameraModel& camera, const View& view)
    : camera_(&camera) {
  const auto* stack = dynamic_cast<const OperatingPointGrid*>(&camera);
  if (!stack || stack->values() == view.conditions) return;
  auto own = std::make_unique<OperatingPointGrid>(*stack);
  own->SetValues(view.conditions);
  owned_model_ = std::move(own);
  camera_ = owned_model_.get();
}

AdjustmentState& AdjustmentState::operator=(const AdjustmentState& other) {
  if (this == &other) return *this;
  cameras.clear();
  for (const auto& camera : other.cameras) cameras.push_back(camera->Clone());
  camera_from_rig = other.camera_from_rig;
  rig_from_pattern = other.rig_from_pattern;
  target_from_board = other.target_from_board;
  points = other.points;
  modes = other.modes;
  deformation_scope = other.deformation_scope;
  flex = other.flex;
  return *this;
}

void AdjustmentState::SetCamera(const CameraModel& camera) {
  std::unique_ptr<CameraModel> copy = camera.Clone();
  cameras.clear();
  cameras.push_back(std::move(copy));
  camera_from_rig = {Pose()};
}

Pose AdjustmentState::ComputeCameraFromPattern(const View& view) const {
  const Pose camera_from_target =
      camera_from_rig[view.camera] * rig_from_pattern[view.pose];
  return view.place < 0 ? camera_from_target
                        : camera_from_target * target_from_board[view.place];
}

void AdjustmentState::ApplyStaticDeformation() {
  if (!HasStaticDeformation()) return;
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    points[i] = DeformedPoint(i);
  SetModes({}, DeformationScope::kBoard);
}

void AdjustmentState::FitStaticDeformation(
    DeformationModes deformation_modes,
    const std::vector<Eigen::Vector3d>& nominal) {
  SetModes(std::move(deformation_modes), DeformationScope::kBoard);
  if (!HasStaticDeformation()) return;
  // The modes of a board are orthogonal and have a mean square of 1.
  std::vector<double> counts(flex.size());
  for (const int board : modes.boards) ++counts[board];
  for (size_t i = 0; i < points.size(); ++i)
    flex[modes.boards[i]] += modes.by_point[i].transpose() *
                             (points[i] - nominal[i]) / counts[modes.boards[i]];
  for (size_t i = 0; i < points.size(); ++i)
    points[i] -= modes.by_point[i] * flex[modes.boards[i]];
}

void AdjustmentState::SetModes(DeformationModes deformation_modes,
                               DeformationScope scope) {
  modes = std::move(deformation_modes);
  deformation_scope = scope;
  flex.assign(scope == DeformationScope::kPose
                  ? rig_from_pattern.size()
                  : static_cast<size_t>(modes.num_boards()),
              DeformationModes::Coefficients::Zero(modes.count()));
}

void AdjustmentState::MoveRigToFirstCamera() {
  const Pose first_from_rig = camera_from_rig.front();
  const Pose rig_from_first = first_from_rig.Inverse();
  for (Pose& pose : camera_from_rig) pose = pose * rig_from_first;
  camera_from_rig.front() = {};
  for (Pose& pose : rig_from_pattern) pose = first_from_rig * pose;
}

int AdjustmentState::NumCameraParameters() const {
  int count = 0;
  for (const auto& camera : cameras) count += camera->NumParameters();
  return count;
}

}  // namespace raygrid
