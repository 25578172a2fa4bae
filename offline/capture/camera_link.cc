#include "capture/camera_link.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "calibration/calibration_problem.h"
#include "capture/camera_information.h"

namespace raygrid {
namespace {

// A board in an image, with its pose estimated by a calibrated camera.
struct AdjustedView {
  Pose camera_from_board;
  std::vector<PointPixelMatch> matches;
};

using ViewsByFrame = std::map<std::pair<std::string, int>, AdjustedView>;

ViewsByFrame GroupViewsByFrame(const AdjustmentResult& adjusted) {
  ViewsByFrame views;
  const CalibrationProblem& problem = adjusted.problem;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    AdjustedView& view = views[{problem.images[v], problem.boards[v]}];
    view.camera_from_board =
        adjusted.state.ComputeCameraFromPattern(problem.views[v]);
    for (const Observation& o : problem.views[v].observations)
      view.matches.push_back({adjusted.state.points[o.point], o.pixel});
  }
  return views;
}

// Returns the information matrix of a small motion of the board, given by
// features with a noise of 1 px.
MotionMatrix MotionInformation(const CameraModel& camera,
                               const std::vector<PointPixelMatch>& features,
                               const Pose& camera_from_board) {
  MotionMatrix information = MotionMatrix::Zero();
  for (const PointPixelMatch& feature : features) {
    const Eigen::Vector3d point = camera_from_board * feature.point;
    LinearizedProjection linear;
    if (!camera.Linearize(point, &feature.pixel, 1, &linear)) continue;
    const Eigen::Matrix<double, 2, 6> J_motion =
        linear.J_point * ComputePointJacobian(point);
    information += J_motion.transpose() * J_motion;
  }
  return information;
}

// Returns the adjoint, which transforms a small motion in the first frame to
// the second.
MotionMatrix ComputeAdjoint(const Pose& second_from_first) {
  const Eigen::Matrix3d rotation =
      second_from_first.rotation.toRotationMatrix();
  MotionMatrix adjoint = MotionMatrix::Zero();
  adjoint.topLeftCorner<3, 3>() = rotation;
  adjoint.bottomRightCorner<3, 3>() = rotation;
  adjoint.bottomLeftCorner<3, 3>() =
      CrossMatrix(second_from_first.translation) * rotation;
  return adjoint;
}

// Inverts a matrix; returns zero if it is singular.
MotionMatrix InvertMotion(const MotionMatrix& matrix) {
  const Eigen::LDLT<MotionMatrix> factor(matrix);
  if (!(factor.vectorD().minCoeff() > 0)) return MotionMatrix::Zero();
  return factor.solve(MotionMatrix::Identity());
}

// Returns the motion, not necessarily small, from one pose to another.
Eigen::Matrix<double, 6, 1> MotionBetween(const Pose& from, const Pose& to) {
  const Pose motion = to * from.Inverse();
  const Eigen::AngleAxisd turn(motion.rotation);
  Eigen::Matrix<double, 6, 1> vector;
  vector << turn.angle() * turn.axis(), motion.translation;
  return vector;
}

}  // namespace

std::optional<CameraLink> CameraLink::Of(const LiveCamera& first,
                                         const LiveCamera& second) {
  if (!first.adjusted() || !second.adjusted()) return std::nullopt;
  const auto make_camera = [](const AdjustmentResult& adjusted) {
    return Camera{
        std::shared_ptr<const CameraModel>(adjusted.state.camera().Clone()),
        adjusted.summary.noise_px};
  };
  CameraLink link;
  link.first_ = make_camera(*first.adjusted());
  link.second_ = make_camera(*second.adjusted());
  const ViewsByFrame in_second = GroupViewsByFrame(*second.adjusted());
  std::vector<SharedBoard> boards;
  for (const auto& [frame, view] : GroupViewsByFrame(*first.adjusted())) {
    const auto other = in_second.find(frame);
    if (other == in_second.end()) continue;
    boards.push_back({view.camera_from_board, other->second.camera_from_board,
                      view.matches, other->second.matches});
  }
  if (boards.empty()) return std::nullopt;
  link.EstimateRelativePose(boards);
  link.EstimateVarianceFactor(boards);
  double num_features = 0;
  for (const SharedBoard& board : boards) {
    link.information_ += link.ComputeInformation(board);
    link.weighing_ += MotionInformation(*link.second_.model, board.in_second,
                                        board.second_from_board);
    num_features += static_cast<double>(board.in_second.size());
  }
  link.weighing_ /= num_features;
  if (InvertMotion(link.information_).isZero(0)) return std::nullopt;
  return link;
}

// Estimates the mean of the boards' relative poses, weighted by their
// information matrices.
void CameraLink::EstimateRelativePose(const std::vector<SharedBoard>& boards) {
  second_from_first_ =
      boards[0].second_from_board * boards[0].first_from_board.Inverse();
  constexpr int kSteps = 5;
  for (int step = 0; step < kSteps; ++step) {
    MotionMatrix sum = MotionMatrix::Zero();
    Eigen::Matrix<double, 6, 1> weighted_motion =
        Eigen::Matrix<double, 6, 1>::Zero();
    for (const SharedBoard& board : boards) {
      const MotionMatrix information = ComputeInformation(board);
      sum += information;
      weighted_motion +=
          information * MotionBetween(second_from_first_,
                                      board.second_from_board *
                                          board.first_from_board.Inverse());
    }
    const Eigen::Matrix<double, 6, 1> motion =
        InvertMotion(sum) * weighted_motion;
    const Pose moved{RotationFromVector(motion.head<3>()), motion.tail<3>()};
    second_from_first_ = moved * second_from_first_;
  }
}

void CameraLink::EstimateVarianceFactor(
    const std::vector<SharedBoard>& boards) {
  if (boards.size() < 2) return;
  double sum = 0;
  for (const SharedBoard& board : boards) {
    const Eigen::Matrix<double, 6, 1> motion =
        MotionBetween(second_from_first_, board.second_from_board *
                                              board.first_from_board.Inverse());
    sum += motion.dot(ComputeInformation(board) * motion);
  }
  constexpr double kPoseSize = 6;
  variance_factor_ =
      std::max(1.0, sum / (kPoseSize * static_cast<double>(boards.size() - 1)));
}

MotionMatrix CameraLink::ComputeInformation(const SharedBoard& shared) const {
  const MotionMatrix first_covariance = InvertMotion(MotionInformation(
      *first_.model, shared.in_first, shared.first_from_board));
  const MotionMatrix second_covariance = InvertMotion(MotionInformation(
      *second_.model, shared.in_second, shared.second_from_board));
  if (first_covariance.isZero(0) || second_covariance.isZero(0))
    return MotionMatrix::Zero();
  const MotionMatrix adjoint = ComputeAdjoint(second_from_first_);
  return InvertMotion(first_.noise_px * first_.noise_px * adjoint *
                          first_covariance * adjoint.transpose() +
                      second_.noise_px * second_.noise_px * second_covariance);
}

double CameraLink::RmsPx() const {
  return std::sqrt(variance_factor_ *
                   (weighing_ * InvertMotion(information_)).trace());
}

double CameraLink::ComputeGain(const SharedBoard& shared) const {
  if (shared.in_first.size() < kMinViewFeatures ||
      shared.in_second.size() < kMinViewFeatures)
    return 0;
  const double before = (weighing_ * InvertMotion(information_)).trace();
  const double after =
      (weighing_ * InvertMotion(information_ + ComputeInformation(shared)))
          .trace();
  return 1 - after / before;
}

double CameraLink::PredictViewGain(const Board& board,
                                   const Pose& first_from_board) const {
  SharedBoard shared;
  shared.first_from_board = first_from_board;
  shared.second_from_board = second_from_first_ * first_from_board;
  shared.in_second =
      PredictVisiblePoints(*second_.model, board, shared.second_from_board);
  if (shared.in_second.size() < kMinViewFeatures) return 0;
  shared.in_first =
      PredictVisiblePoints(*first_.model, board, first_from_board);
  return ComputeGain(shared);
}

}  // namespace raygrid
