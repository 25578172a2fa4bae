#include "shutter/frame_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>

namespace raygrid {
namespace {

constexpr double kHuberPx = 1;  // as in bundle adjustment

// Returns the polynomial terms in board coordinates, up to third degree.
Eigen::Matrix<double, kBoardTerms, 1> EvaluateBoardTerms(
    const Eigen::Vector2d& place) {
  const double x = place.x(), y = place.y();
  Eigen::Matrix<double, kBoardTerms, 1> terms;
  terms << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y,
      y * y * y;
  return terms;
}

// Returns the polynomial terms in pixel coordinates, up to fourth degree; the
// longer side of the image is scaled to [-1, 1].
Eigen::Matrix<double, kImageTerms, 1> EvaluateImageTerms(
    const Eigen::Vector2d& pixel, const ImageSize& size) {
  const double half = std::max(size.width, size.height) / 2.0;
  const double x = (pixel.x() - size.width / 2.0) / half;
  const double y = (pixel.y() - size.height / 2.0) / half;
  Eigen::Matrix<double, kImageTerms, 1> terms;
  terms << EvaluateBoardTerms({x, y}), x * x * x * x, x * x * x * y,
      x * x * y * y, x * y * y * y, y * y * y * y;
  return terms;
}

// A residual with its Jacobians with respect to the pose and the shared
// parameters.
struct PointEquations {
  Eigen::Vector2d error_px;
  Eigen::Matrix<double, 2, 6> J_pose;
  Eigen::Matrix<double, 2, kShared> J_shared;
  double row = 0;  // relative to the middle row
};

// Returns the predicted pixel of a point at the time when its observed row is
// read out. Jacobians that are evaluated there do not depend on the noise of
// the observation.
std::optional<Eigen::Vector2d> PredictPixelAtRow(const FrameInput& input,
                                                 const TrackPoint& point) {
  const double reference_row = GetReferenceRow(input.camera->image_size());
  const double seconds = input.shared[0] * (point.pixel.y() - reference_row);
  return input.camera->Project(
      input.motion.PoseAfter(seconds, input.pose) * point.point, &point.pixel,
      kShutterMarginPx);
}

// Linearizes a residual; returns false if the camera cannot project the point.
bool LinearizePoint(const FrameInput& input, const TrackPoint& point,
                    PointEquations* equations) {
  const SharedVector& shared = input.shared;
  const auto place = PredictPixelAtRow(input, point);
  if (!place) return false;
  const double row = place->y() - GetReferenceRow(input.camera->image_size());
  const auto image_terms =
      EvaluateImageTerms(*place, input.camera->image_size());
  const auto board_terms = EvaluateBoardTerms(point.place);
  Eigen::Vector3d on_board = point.point;
  for (int k = 0; k < 3; ++k)
    on_board[k] += input.half_m * board_terms.dot(shared.segment<kBoardTerms>(
                                      kNumFrameParameters + k * kBoardTerms));
  const double seconds = shared[0] * row;
  const Pose pose_then = input.motion.PoseAfter(seconds, input.pose);
  const Eigen::Vector3d turned = pose_then.rotation * on_board;
  LinearizedProjection projection;
  if (!input.camera->Linearize(turned + pose_then.translation, &point.pixel,
                               kShutterMarginPx, &projection))
    return false;
  equations->error_px = projection.pixel - point.pixel;
  Eigen::Matrix3d J_rotation;                // Jacobian of rotation x turned
  J_rotation << 0, turned.z(), -turned.y(),  //
      -turned.z(), 0, turned.x(),            //
      turned.y(), -turned.x(), 0;
  equations->J_pose << projection.J_point * J_rotation, projection.J_point;
  auto& J_shared = equations->J_shared;
  J_shared.setZero();
  equations->row = row;
  J_shared.col(0) = row * equations->J_pose * input.motion.VelocityAt(seconds);
  for (int k = 0; k < 2; ++k) {
    const int first = 1 + k * kImageTerms;
    equations->error_px[k] +=
        image_terms.dot(shared.segment<kImageTerms>(first));
    J_shared.block<1, kImageTerms>(k, first) = image_terms.transpose();
  }
  const Eigen::Matrix<double, 2, 3> J_point =
      input.half_m * projection.J_point * pose_then.rotation.toRotationMatrix();
  for (int k = 0; k < 3; ++k)
    J_shared.block<2, kBoardTerms>(0, kNumFrameParameters + k * kBoardTerms) =
        J_point.col(k) * board_terms.transpose();
  return J_shared.allFinite() && equations->error_px.allFinite();
}

}  // namespace

double GetReferenceRow(const ImageSize& size) {
  return (size.height - 1) / 2.0;
}

FrameEquations MakeFrameEquations(const FrameInput& input,
                                  SharedMatrix* information) {
  FrameEquations sum;
  PointEquations one;
  for (const TrackPoint& point : *input.points) {
    if (!LinearizePoint(input, point, &one)) continue;
    const double weight =
        std::min(1.0, kHuberPx / std::max(1e-9, one.error_px.norm()));
    const Matrix6d square = weight * one.J_pose.transpose() * one.J_pose;
    sum.pose += square;
    sum.by_row += one.row * square;
    sum.by_row2 += one.row * one.row * square;
    sum.pose_gradient += weight * one.J_pose.transpose() * one.error_px;
    sum.mixed.noalias() += weight * one.J_pose.transpose() * one.J_shared;
    information->noalias() += weight * one.J_shared.transpose() * one.J_shared;
    sum.gradient += weight * one.J_shared.transpose() * one.error_px;
    sum.squares += weight * one.error_px.squaredNorm();
    ++sum.num_points;
  }
  sum.pose_covariance = sum.pose.ldlt().solve(Matrix6d::Identity());
  const Eigen::Matrix<double, 6, kShared> J_pose_at_row =
      sum.pose_covariance * sum.mixed;
  information->noalias() -= sum.mixed.transpose() * J_pose_at_row;
  sum.gradient -= J_pose_at_row.transpose() * sum.pose_gradient;
  return sum;
}

}  // namespace raygrid
