#include "adjustment/metric_scale.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

// nominal = scale rotation point + translation.
struct Similarity {
  double scale = 1;
  Eigen::Quaterniond rotation;
  Eigen::Vector3d point_center, nominal_center;
  double squared_extent = 0;  // of the points

  Eigen::Vector3d translation() const {
    return nominal_center - scale * (rotation * point_center);
  }
};

Similarity BestSimilarity(const AlignedBoard& board,
                          const AdjustmentState& state, bool scale_is_free) {
  const Eigen::Index count = static_cast<Eigen::Index>(board.nominal.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = state.points[board.first + i];
    to.col(i) = board.nominal[i];
  }
  const Eigen::Matrix3d linear =
      Eigen::umeyama(from, to, scale_is_free).topLeftCorner<3, 3>();
  Similarity best;
  best.scale = std::cbrt(linear.determinant());
  best.rotation = Eigen::Quaterniond(Eigen::Matrix3d(linear / best.scale));
  best.point_center = from.rowwise().mean();
  best.nominal_center = to.rowwise().mean();
  best.squared_extent = (from.colwise() - best.point_center).squaredNorm();
  return best;
}

void Apply(const Similarity& similarity, const AlignedBoard& board,
           AdjustmentState* state) {
  const double s = similarity.scale;
  const Eigen::Quaterniond& r = similarity.rotation;
  const Eigen::Vector3d t = similarity.translation();
  const Eigen::Matrix3d rotation = r.toRotationMatrix();
  for (size_t i = 0; i < board.nominal.size(); ++i) {
    Eigen::Vector3d& point = state->points[board.first + i];
    point = s * (r * point) + t;
    // s R (p + M f) + t is s R p + t with the modes R M and the flex s f.
    if (state->modes.count() > 0) {
      auto& displacements = state->modes.by_point[board.first + i];
      displacements = (rotation * displacements).eval();
    }
  }
  // s (Q p + u) = Q R^-1 (s R p + t) + s u - Q R^-1 t
  for (const int index : board.poses) {
    Pose& pose = state->rig_from_pattern[index];
    pose.rotation = (pose.rotation * r.inverse()).normalized();
    pose.translation = s * pose.translation - pose.rotation * t;
    if (state->modes.count() > 0) state->flex[index] *= s;
  }
}

// The similarities' scales become one, by least squares over all points.
double CommonScale(const std::vector<Similarity>& similarities) {
  double sum = 0, weight = 0;
  for (const Similarity& similarity : similarities) {
    sum += similarity.scale * similarity.squared_extent;
    weight += similarity.squared_extent;
  }
  return weight > 0 ? sum / weight : 1;
}

}  // namespace

void AlignToNominal(const std::vector<AlignedBoard>& boards,
                    AdjustmentState* state) {
  // Lines that do not meet in a point have a scale.
  const bool scale_is_free =
      std::all_of(state->cameras.begin(), state->cameras.end(),
                  [](const auto& camera) { return camera->IsCentral(); });
  std::vector<Similarity> similarities;
  for (const AlignedBoard& board : boards)
    similarities.push_back(BestSimilarity(board, *state, scale_is_free));
  if (scale_is_free && state->cameras.size() > 1) {
    const double scale = CommonScale(similarities);
    for (Similarity& similarity : similarities) similarity.scale = scale;
    for (Pose& pose : state->camera_from_rig) pose.translation *= scale;
  }
  for (size_t b = 0; b < boards.size(); ++b)
    Apply(similarities[b], boards[b], state);
}

}  // namespace raygrid
