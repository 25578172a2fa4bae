#include "adjustment/reprojection_error.h"

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// The index of each view's first observation, and their total at the end.
std::vector<int> FirstObservations(const std::vector<View>& views) {
  std::vector<int> first = {0};
  for (const View& view : views)
    first.push_back(first.back() + static_cast<int>(view.observations.size()));
  return first;
}

LinearizedResidual Linearize(const AdjustmentState& state, int view,
                             const Observation& observation) {
  LinearizedResidual result;
  result.view = view;
  result.point = observation.point;
  const Pose& pose = state.camera_from_pattern[view];
  const Eigen::Vector3d rotated =
      pose.rotation * state.points[observation.point];
  const Eigen::Vector3d in_camera = rotated + pose.translation;
  if (!state.camera->Linearize(in_camera, &observation.pixel,
                               kAdjustmentMarginPx, &result.projection))
    return result;
  result.residual = {true, result.projection.pixel - observation.pixel};

  // d(exp(w) R p + t + v) = -[R p]x w + v
  Eigen::Matrix3d minus_cross;
  minus_cross << 0, rotated.z(), -rotated.y(), -rotated.z(), 0, rotated.x(),
      rotated.y(), -rotated.x(), 0;
  result.by_pose << result.projection.by_point * minus_cross,
      result.projection.by_point;
  result.by_point =
      result.projection.by_point * pose.rotation.toRotationMatrix();
  return result;
}

}  // namespace

std::vector<Residual> ComputeResiduals(const AdjustmentState& state,
                                       const std::vector<View>& views,
                                       int num_threads) {
  const std::vector<int> first = FirstObservations(views);
  std::vector<Residual> residuals(first.back());
  ParallelFor(static_cast<int>(views.size()), num_threads, [&](int v) {
    for (size_t i = 0; i < views[v].observations.size(); ++i) {
      const Observation& observation = views[v].observations[i];
      const auto pixel = state.camera->Project(
          state.camera_from_pattern[v] * state.points[observation.point],
          &observation.pixel, kAdjustmentMarginPx);
      if (pixel) residuals[first[v] + i] = {true, *pixel - observation.pixel};
    }
  });
  return residuals;
}

std::vector<LinearizedResidual> LinearizeResiduals(
    const AdjustmentState& state, const std::vector<View>& views,
    int num_threads) {
  const std::vector<int> first = FirstObservations(views);
  std::vector<LinearizedResidual> residuals(first.back());
  ParallelFor(static_cast<int>(views.size()), num_threads, [&](int v) {
    for (size_t i = 0; i < views[v].observations.size(); ++i)
      residuals[first[v] + i] = Linearize(state, v, views[v].observations[i]);
  });
  return residuals;
}

double HuberLoss(double norm_px, double huber_px) {
  return norm_px <= huber_px ? norm_px * norm_px / 2
                             : huber_px * (norm_px - huber_px / 2);
}

double HuberWeight(double norm_px, double huber_px) {
  return norm_px <= huber_px ? 1 : huber_px / norm_px;
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
