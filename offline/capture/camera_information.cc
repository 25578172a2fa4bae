#include "capture/camera_information.h"

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "adjustment/covariance.h"
#include "adjustment/normal_equations.h"
#include "capture/pose_derivative.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Maximum number of features per view; a subset is weighted accordingly.
constexpr size_t kMaxFeatures = 64;

// Jacobian of a view's pixels, two rows per feature. It is sparse: a projection
// depends only on nearby control points.
struct ViewJacobians {
  Eigen::SparseMatrix<double, Eigen::RowMajor> by_parameters;
  Eigen::Matrix<double, Eigen::Dynamic, 6> J_pose;
};

void AddRows(const LinearizedProjection& linear, int row,
             std::vector<Eigen::Triplet<double>>* entries) {
  const auto add = [&](int column, const Eigen::Vector2d& derivative) {
    for (int i = 0; i < 2; ++i)
      entries->emplace_back(row + i, column, derivative[i]);
  };
  for (int n = 0; n < linear.num_nodes; ++n)
    for (int i = 0; i < linear.num_per_node; ++i)
      add(linear.node_parameter[n] + i,
          linear.node_weight[n] * linear.J_node.col(i));
  for (int i = 0; i < linear.num_global; ++i)
    add(linear.first_global + i, linear.J_global.col(i));
}

// Computes the weighted Jacobian of a subset of features. Features without a
// projection are omitted.
ViewJacobians ComputeViewJacobian(const CameraModel& camera, int num_parameters,
                                  const std::vector<Eigen::Vector3d>& points,
                                  const std::vector<Eigen::Vector2d>& pixels,
                                  const Pose& camera_from_points) {
  const size_t count = std::min(points.size(), kMaxFeatures);
  const double root = std::sqrt(static_cast<double>(points.size()) /
                                std::max<double>(1, count));
  ViewJacobians view;
  view.by_parameters.resize(2 * static_cast<Eigen::Index>(count),
                            num_parameters);
  view.J_pose.setZero(view.by_parameters.rows(), 6);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t k = 0; k < count; ++k) {
    const size_t i = k * points.size() / count;
    const Eigen::Vector3d point = camera_from_points * points[i];
    LinearizedProjection linear;
    if (!camera.Linearize(point, &pixels[i], 1, &linear)) continue;
    AddRows(linear, static_cast<int>(2 * k), &entries);
    view.J_pose.middleRows<2>(2 * static_cast<Eigen::Index>(k)) =
        linear.J_point * ComputePointJacobian(point);
  }
  view.by_parameters.setFromTriplets(entries.begin(), entries.end());
  view.by_parameters *= root;
  return view;
}

// Returns the pseudo-inverse of J_pose: maps pixel displacements to the
// least-squares pose step.
Eigen::Matrix<double, 6, Eigen::Dynamic> ComputePoseElimination(
    const ViewJacobians& view) {
  const MotionMatrix square = view.J_pose.transpose() * view.J_pose;
  return square.ldlt().solve(view.J_pose.transpose());
}

// Returns J^T J, where J is the Jacobian after elimination of the pose (Schur
// complement).
Eigen::MatrixXd PoseFreeSquare(const ViewJacobians& view) {
  Eigen::MatrixXd j = view.by_parameters;
  const Eigen::MatrixXd made_up =
      ComputePoseElimination(view) * view.by_parameters;
  j.noalias() -= view.J_pose * made_up;
  return j.transpose() * j;
}

// Returns J M J^T for a symmetric M. The pose is eliminated last, to retain the
// sparsity of the Jacobian in products.
Eigen::MatrixXd PoseFreeProduct(const ViewJacobians& view,
                                const Eigen::MatrixXd& matrix) {
  // Row-major, because whole rows are added.
  using RowMatrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const RowMatrix half =
      view.by_parameters *
      Eigen::Map<const RowMatrix>(matrix.data(), matrix.rows(), matrix.cols());
  Eigen::MatrixXd product = view.by_parameters * half.transpose();
  const Eigen::Matrix<double, 6, Eigen::Dynamic> pose =
      ComputePoseElimination(view);
  product -= view.J_pose * (pose * product).eval();
  product -= (product * pose.transpose()).eval() * view.J_pose.transpose();
  return product;
}

}  // namespace

std::optional<CameraInformation> CameraInformation::Of(
    const AdjustmentResult& adjusted) {
  constexpr UncertaintyOptions kLattice;
  const AdjustmentState& state = adjusted.state;
  CameraInformation information;
  information.camera_ = state.camera().Clone();
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
    h += PoseFreeSquare(
        ComputeViewJacobian(*information.camera_, size, points, pixels,
                            state.ComputeCameraFromPattern(view)));
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(h);
  if (factor.info() != Eigen::Success) return std::nullopt;
  information.inverse_ = factor.solve(Eigen::MatrixXd::Identity(size, size));
  std::vector<PixelUncertainty> pixels;
  std::vector<bool> is_known;
  const Eigen::MatrixXd moves = ComputeLatticeJacobian(
      adjusted.problem.views, state, 0, kLattice, &pixels, &is_known);
  const Eigen::MatrixXd projected_motions = moves * information.inverse_;
  double trace = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (!is_known[i] || !information.camera_->IsInImageCircle(pixels[i].pixel))
      continue;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const double sum = projected_motions.middleRows<2>(row)
                           .cwiseProduct(moves.middleRows<2>(row))
                           .sum();
    trace += sum;
    information.positions_.push_back(
        {pixels[i].pixel, adjusted.summary.noise_px * std::sqrt(sum)});
  }
  if (!(trace > 0)) return std::nullopt;
  information.weighing_ =
      projected_motions.transpose() * projected_motions / trace;
  return information;
}

double CameraInformation::RmsPx() const {
  double sum = 0;
  for (const UncertaintySample& place : positions_)
    sum += place.stddev_px * place.stddev_px;
  return std::sqrt(sum / static_cast<double>(positions_.size()));
}

double CameraInformation::Percentile95Px() const {
  std::vector<double> deviations;
  for (const UncertaintySample& place : positions_)
    deviations.push_back(place.stddev_px);
  return Quantile(deviations, 0.95);
}

double CameraInformation::ComputeGain(
    const std::vector<Eigen::Vector3d>& points,
    const std::vector<Eigen::Vector2d>& pixels,
    const Pose& camera_from_points) const {
  if (points.empty()) return 0;
  const ViewJacobians view =
      ComputeViewJacobian(*camera_, static_cast<int>(inverse_.rows()), points,
                          pixels, camera_from_points);
  Eigen::MatrixXd scatter = PoseFreeProduct(view, inverse_);
  scatter.diagonal().array() += 1;
  const Eigen::MatrixXd gained = PoseFreeProduct(view, weighing_);
  return scatter.llt().solve(gained).trace();
}

Area GetFeatureArea(const ImageSize& size) {
  constexpr double kWindowPx = 11;
  return {kWindowPx, kWindowPx, size.width - 1 - kWindowPx,
          size.height - 1 - kWindowPx};
}

std::vector<PointPixelMatch> PredictVisiblePoints(
    const CameraModel& camera, const Board& board,
    const Pose& camera_from_board) {
  const Area image = GetFeatureArea(camera.image_size());
  std::vector<PointPixelMatch> seen;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      if (!board.HasFeature(column, row)) continue;
      const Eigen::Vector3d point = board.points[board.PointIndex(column, row)];
      const auto pixel = camera.Project(camera_from_board * point);
      if (pixel && image.Contains(*pixel) && camera.IsInImageCircle(*pixel))
        seen.push_back({point, *pixel});
    }
  return seen;
}

double CameraInformation::PredictViewGain(const Board& board,
                                          const Pose& camera_from_board) const {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (const PointPixelMatch& seen :
       PredictVisiblePoints(*camera_, board, camera_from_board)) {
    points.push_back(seen.point);
    pixels.push_back(seen.pixel);
  }
  return ComputeGain(points, pixels, camera_from_board);
}

}  // namespace raygrid
