#include "adjustment/metric_scale.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

// Similarity transform: nominal = scale * rotation * point + translation.
struct Similarity {
  double scale = 1;
  Eigen::Quaterniond rotation;
  Eigen::Vector3d point_center, nominal_center;
  double squared_extent = 0;  // squared extent of the points

  Eigen::Vector3d translation() const {
    return nominal_center - scale * (rotation * point_center);
  }
};

Similarity EstimateSimilarity(const AlignedBoard& board,
                              const AdjustmentState& state,
                              bool scale_is_free) {
  const Eigen::Index count = static_cast<Eigen::Index>(board.nominal.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = state.DeformedPoint(board.first + static_cast<int>(i));
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
    // s R (p + M f) + t equals s R p + t with the modes R M and the deformation
    // s f.
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
    if (state->HasPerViewDeformation()) state->flex[index] *= s;
  }
  if (state->HasStaticDeformation())
    state->flex[state->modes.boards[board.first]] *= s;
}

// Updates target_from_board after alignment to the nominal points: x' = s R x +
// t for the target, and x' = s Q y + u for a point y of the board.
void TransformBoardPose(const Similarity& body, const Similarity& board,
                        Pose* target_from_board) {
  Pose& pose = *target_from_board;
  const Eigen::Vector3d moved =
      body.scale * (body.rotation * pose.translation) + body.translation();
  pose.rotation =
      (body.rotation * pose.rotation * board.rotation.inverse()).normalized();
  pose.translation = moved - pose.rotation * board.translation();
}

// Returns the least-squares scale that is common to all similarities.
double ComputeCommonScale(const std::vector<Similarity>& similarities) {
  double sum = 0, weight = 0;
  for (const Similarity& similarity : similarities) {
    sum += similarity.scale * similarity.squared_extent;
    weight += similarity.squared_extent;
  }
  return weight > 0 ? sum / weight : 1;
}

// Assigns a common scale to all boards of a rigid multi-board target.
void ShareScaleOnTargets(const std::vector<AlignedBoard>& boards,
                         std::vector<Similarity>* similarities) {
  for (const AlignedBoard& frame : boards) {
    if (frame.body < 0 || frame.place >= 0) continue;
    std::vector<Similarity> body_similarities;
    for (size_t b = 0; b < boards.size(); ++b)
      if (boards[b].body == frame.body)
        body_similarities.push_back((*similarities)[b]);
    const double scale = ComputeCommonScale(body_similarities);
    for (size_t b = 0; b < boards.size(); ++b)
      if (boards[b].body == frame.body) (*similarities)[b].scale = scale;
  }
}

// Updates target_from_board for the boards of a rigid target, relative to the
// board that defines its frame.
void TransformBoardPoses(const std::vector<AlignedBoard>& boards,
                         const std::vector<Similarity>& similarities,
                         size_t frame, AdjustmentState* state) {
  for (size_t b = 0; b < boards.size(); ++b)
    if (boards[b].body == boards[frame].body && boards[b].place >= 0)
      TransformBoardPose(similarities[frame], similarities[b],
                         &state->target_from_board[boards[b].place]);
}

}  // namespace

void AlignToNominal(const std::vector<AlignedBoard>& boards,
                    AdjustmentState* state) {
  // The scale is observable if observation lines of a camera do not intersect.
  const bool scale_is_free =
      std::all_of(state->cameras.begin(), state->cameras.end(),
                  [](const auto& camera) { return camera->IsCentral(); });
  std::vector<Similarity> similarities;
  for (const AlignedBoard& board : boards)
    similarities.push_back(EstimateSimilarity(board, *state, scale_is_free));
  if (scale_is_free && state->cameras.size() > 1) {
    const double scale = ComputeCommonScale(similarities);
    for (Similarity& similarity : similarities) similarity.scale = scale;
    for (Pose& pose : state->camera_from_rig) pose.translation *= scale;
  } else if (scale_is_free) {
    ShareScaleOnTargets(boards, &similarities);
  }
  for (size_t b = 0; b < boards.size(); ++b) {
    Apply(similarities[b], boards[b], state);
    if (boards[b].body >= 0 && boards[b].place < 0)
      TransformBoardPoses(boards, similarities, b, state);
  }
}

}  // namespace raygrid
