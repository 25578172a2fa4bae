#include "capture/camera_knowledge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "adjustment/covariance.h"
#include "adjustment/normal_equations.h"
#include "capture/pose_derivative.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// The features of a view that stand for all of them, each counting for more.
constexpr size_t kMaxFeatures = 64;

// The derivatives of a view's pixels by the camera's parameters, two rows a
// feature, less what the view's pose can make up for. Features that the camera
// does not see are left out.
Eigen::MatrixXd PoseFreeJacobian(const CameraModel& camera, int num_parameters,
                                 const std::vector<Eigen::Vector3d>& points,
                                 const std::vector<Eigen::Vector2d>& pixels,
                                 const Pose& camera_from_points) {
  const size_t count = std::min(points.size(), kMaxFeatures);
  Eigen::MatrixXd by_parameters = Eigen::MatrixXd::Zero(
      2 * static_cast<Eigen::Index>(count), num_parameters);
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_pose(by_parameters.rows(), 6);
  by_pose.setZero();
  for (size_t k = 0; k < count; ++k) {
    const size_t i = k * points.size() / count;
    const Eigen::Vector3d point = camera_from_points * points[i];
    LinearizedProjection linear;
    if (!camera.Linearize(point, &pixels[i], 1, &linear)) continue;
    const auto row = 2 * static_cast<Eigen::Index>(k);
    auto rows = by_parameters.middleRows<2>(row);
    for (int n = 0; n < linear.num_nodes; ++n)
      rows.middleCols(linear.node_parameter[n], linear.num_per_node) +=
          linear.node_weight[n] * linear.by_node.leftCols(linear.num_per_node);
    if (linear.num_global > 0)
      rows.middleCols(linear.first_global, linear.num_global) +=
          linear.by_global.leftCols(linear.num_global);
    by_pose.middleRows<2>(row) = linear.by_point * PointByMotion(point);
  }
  const double root = std::sqrt(static_cast<double>(points.size()) /
                                std::max<size_t>(1, count));
  const MotionMatrix square = by_pose.transpose() * by_pose;
  const Eigen::MatrixXd made_up =
      square.ldlt().solve(by_pose.transpose() * by_parameters);
  return root * (by_parameters - by_pose * made_up);
}

}  // namespace

std::optional<CameraKnowledge> CameraKnowledge::Of(const Adjusted& adjusted) {
  constexpr UncertaintyOptions kLattice;
  const AdjustmentState& state = adjusted.state;
  CameraKnowledge knowledge;
  knowledge.camera_ = state.camera().Clone();
  const ParameterLayout layout(state, {false, true});
  const PriorEquations prior(adjusted.prior, state, layout);
  const int size = layout.size;
  Eigen::MatrixXd h = prior.Times(Eigen::MatrixXd::Identity(size, size));
  for (const View& view : adjusted.problem.views) {
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> pixels;
    for (const Observation& o : view.observations) {
      points.push_back(state.points[o.point]);
      pixels.push_back(o.pixel);
    }
    const Eigen::MatrixXd j =
        PoseFreeJacobian(*knowledge.camera_, size, points, pixels,
                         state.CameraFromPattern(view));
    h.noalias() += j.transpose() * j;
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(h);
  if (factor.info() != Eigen::Success) return std::nullopt;
  knowledge.inverse_ = factor.solve(Eigen::MatrixXd::Identity(size, size));
  std::vector<PixelUncertainty> pixels;
  std::vector<bool> is_known;
  const Eigen::MatrixXd moves = MovesOfLattice(adjusted.problem.views, state, 0,
                                               kLattice, &pixels, &is_known);
  const Eigen::MatrixXd moves_by_inverse = moves * knowledge.inverse_;
  double trace = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (!is_known[i] || !knowledge.camera_->IsLit(pixels[i].pixel)) continue;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const double sum = moves_by_inverse.middleRows<2>(row)
                           .cwiseProduct(moves.middleRows<2>(row))
                           .sum();
    trace += sum;
    knowledge.places_.push_back(
        {pixels[i].pixel, adjusted.summary.noise_px * std::sqrt(sum)});
  }
  if (!(trace > 0)) return std::nullopt;
  knowledge.weighing_ = moves_by_inverse.transpose() * moves_by_inverse / trace;
  return knowledge;
}

double CameraKnowledge::RmsPx() const {
  double sum = 0;
  for (const KnownPlace& place : places_)
    sum += place.deviation_px * place.deviation_px;
  return std::sqrt(sum / static_cast<double>(places_.size()));
}

double CameraKnowledge::Percentile95Px() const {
  std::vector<double> deviations;
  for (const KnownPlace& place : places_)
    deviations.push_back(place.deviation_px);
  return Quantile(deviations, 0.95);
}

double CameraKnowledge::GainOf(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Eigen::Vector2d>& pixels,
                               const Pose& camera_from_points) const {
  if (points.empty()) return 0;
  const Eigen::MatrixXd j =
      PoseFreeJacobian(*camera_, static_cast<int>(inverse_.rows()), points,
                       pixels, camera_from_points);
  Eigen::MatrixXd scatter = j * inverse_ * j.transpose();
  scatter.diagonal().array() += 1;
  const Eigen::MatrixXd gained = j * weighing_ * j.transpose();
  return scatter.llt().solve(gained).trace();
}

Area AreaOfFeatures(const ImageSize& size) {
  constexpr double kWindowPx = 11;
  return {kWindowPx, kWindowPx, size.width - 1 - kWindowPx,
          size.height - 1 - kWindowPx};
}

std::vector<SeenPoint> SeenPoints(const CameraModel& camera, const Board& board,
                                  const Pose& camera_from_board) {
  const Area image = AreaOfFeatures(camera.image_size());
  std::vector<SeenPoint> seen;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      if (!board.HasFeature(column, row)) continue;
      const Eigen::Vector3d point = board.points[board.PointIndex(column, row)];
      const auto pixel = camera.Project(camera_from_board * point);
      if (pixel && image.Contains(*pixel) && camera.IsLit(*pixel))
        seen.push_back({point, *pixel});
    }
  return seen;
}

double CameraKnowledge::GainOfView(const Board& board,
                                   const Pose& camera_from_board) const {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (const SeenPoint& seen : SeenPoints(*camera_, board, camera_from_board)) {
    points.push_back(seen.point);
    pixels.push_back(seen.pixel);
  }
  return GainOf(points, pixels, camera_from_board);
}

}  // namespace raygrid
