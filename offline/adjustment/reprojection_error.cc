#include "adjustment/reprojection_error.h"

#include <algorithm>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// Returns the index of each view's first observation, and the total number of
// observations.
std::vector<int> FirstObservations(const std::vector<View>& views) {
  std::vector<int> first = {0};
  for (const View& view : views)
    first.push_back(first.back() + static_cast<int>(view.observations.size()));
  return first;
}

// Returns the Jacobian with respect to the pose update: d(exp(w) R p + t + v) =
// -[R p]x w + v.
Eigen::Matrix<double, 3, 6> UpdateDerivative(const Eigen::Vector3d& rotated) {
  Eigen::Matrix<double, 3, 6> derivative;
  derivative << 0, rotated.z(), -rotated.y(), 1, 0, 0,  //
      -rotated.z(), 0, rotated.x(), 0, 1, 0,            //
      rotated.y(), -rotated.x(), 0, 0, 0, 1;
  return derivative;
}

LinearizedResidual Linearize(const AdjustmentState& state,
                             const CameraModel& camera, const View& view,
                             const Observation& observation) {
  LinearizedResidual result;
  result.camera = view.camera;
  result.pose = view.pose;
  result.place = view.place;
  result.point = observation.point;
  const Pose& pose = state.rig_from_pattern[view.pose];
  const Pose& camera_pose = state.camera_from_rig[view.camera];
  Eigen::Vector3d point = state.PointAt(view.pose, observation.point);
  Eigen::Vector3d rotated_on_target(0, 0, 0);
  if (view.place >= 0) {
    const Pose& place = state.target_from_board[view.place];
    rotated_on_target = place.rotation * point;
    point = rotated_on_target + place.translation;
  }
  const Eigen::Vector3d rotated = pose.rotation * point;
  const Eigen::Vector3d rotated_to_camera =
      camera_pose.rotation * (rotated + pose.translation);
  if (!camera.Linearize(rotated_to_camera + camera_pose.translation,
                        &observation.pixel, kAdjustmentMarginPx,
                        &result.projection))
    return result;
  result.residual = {true, result.projection.pixel - observation.pixel};
  const Eigen::Matrix<double, 2, 3>& J_point = result.projection.J_point;
  const Eigen::Matrix<double, 2, 3> J_rig_point =
      J_point * camera_pose.rotation.toRotationMatrix();
  result.J_camera_pose = J_point * UpdateDerivative(rotated_to_camera);
  result.J_pose = J_rig_point * UpdateDerivative(rotated);
  result.J_point = J_rig_point * pose.rotation.toRotationMatrix();
  if (view.place >= 0) {
    result.J_board_pose = result.J_point * UpdateDerivative(rotated_on_target);
    result.J_point =
        (result.J_point *
         state.target_from_board[view.place].rotation.toRotationMatrix())
            .eval();
  }
  if (state.HasPerViewDeformation())
    result.J_deformation =
        result.J_point * state.modes.by_point[observation.point];
  return result;
}

}  // namespace

std::vector<Residual> ComputeResiduals(const AdjustmentState& state,
                                       const std::vector<View>& views,
                                       int num_threads) {
  const std::vector<int> first = FirstObservations(views);
  std::vector<Residual> residuals(first.back());
  ParallelFor(static_cast<int>(views.size()), num_threads, [&](int v) {
    const CameraAtView camera = state.GetCamera(views[v]);
    const Pose pose = state.ComputeCameraFromPattern(views[v]);
    for (size_t i = 0; i < views[v].observations.size(); ++i) {
      const Observation& observation = views[v].observations[i];
      const auto pixel = camera->Project(
          pose * state.PointAt(views[v].pose, observation.point),
          &observation.pixel, kAdjustmentMarginPx);
      if (pixel) residuals[first[v] + i] = {true, *pixel - observation.pixel};
    }
  });
  return residuals;
}

std::vector<LinearizedResidual> LinearizeView(const AdjustmentState& state,
                                              const View& view) {
  std::vector<LinearizedResidual> residuals;
  residuals.reserve(view.observations.size());
  const CameraAtView camera = state.GetCamera(view);
  for (const Observation& observation : view.observations)
    residuals.push_back(Linearize(state, *camera, view, observation));
  return residuals;
}

double HuberLoss(double norm_px, double huber_px) {
  return norm_px <= huber_px ? norm_px * norm_px / 2
                             : huber_px * (norm_px - huber_px / 2);
}

double HuberWeight(double norm_px, double huber_px) {
  return norm_px <= huber_px ? 1 : huber_px / norm_px;
}

double ResidualVariance(const std::vector<Residual>& residuals, double huber_px,
                        double num_parameters) {
  double sum = 0, count = 0;
  for (const Residual& residual : residuals) {
    if (!residual.valid) continue;
    const double norm = residual.error_px.norm();
    const double weight = HuberWeight(norm, huber_px);
    sum += weight * norm * norm;
    count += 2 * weight;
  }
  return sum / std::max(count - num_parameters, 0.1 * count + 1);
}

ComparableCosts CompareCosts(const std::vector<Residual>& first,
                             const std::vector<Residual>& second,
                             double huber_px) {
  ComparableCosts costs;
  for (size_t i = 0; i < first.size(); ++i) {
    if (!first[i].valid || !second[i].valid) continue;
    costs.first += HuberLoss(first[i].error_px.norm(), huber_px);
    costs.second += HuberLoss(second[i].error_px.norm(), huber_px);
    ++costs.num_common;
  }
  return costs;
}

}  // namespace raygrid
