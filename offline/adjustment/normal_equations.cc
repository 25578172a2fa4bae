#include "adjustment/normal_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <random>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// The columns of a residual's Jacobian in the dense system, gathered.
struct GatheredJacobian {
  static constexpr int kMax = LinearizedProjection::kMaxParameters + 12;
  int count = 0;
  std::array<int, kMax> column;
  Eigen::Matrix<double, 2, kMax> value;

  // Columns must ascend from call to call.
  template <typename Derived>
  void Add(int first_column, const Eigen::MatrixBase<Derived>& derivative) {
    for (int k = 0; k < derivative.cols(); ++k) {
      column[count] = first_column + k;
      value.col(count++) = derivative.col(k);
    }
  }

  void AddCamera(int first_column, const LinearizedProjection& projection) {
    for (int k = 0; k < projection.num_nodes; ++k)
      Add(first_column + projection.node_parameter[k],
          projection.node_weight[k] *
              projection.by_node.leftCols(projection.num_per_node));
    Add(first_column + projection.first_global,
        projection.by_global.leftCols(projection.num_global));
  }
};

// A floor for the damping, so that a parameter that nothing depends on does not
// make the system singular.
constexpr double kDampingFloor = 1e-9;

// *matrix -= factor factor^T, lower triangle. In panels of rows whose number
// does not depend on the threads, so that neither does the result.
void SubtractProduct(const Eigen::MatrixXd& factor, int num_threads,
                     Eigen::MatrixXd* matrix) {
  constexpr int kPanel = 128;
  const int size = static_cast<int>(matrix->rows());
  const int num_panels = (size + kPanel - 1) / kPanel;
  ParallelFor(num_panels, num_threads, [&](int i) {
    // The last panels are the longest: first.
    const int begin = (num_panels - 1 - i) * kPanel;
    const int rows = std::min(kPanel, size - begin);
    matrix->block(begin, 0, rows, begin + rows).noalias() -=
        factor.middleRows(begin, rows) *
        factor.topRows(begin + rows).transpose();
  });
}

}  // namespace

NormalEquations::Sizes NormalEquations::SizesOf(const AdjustmentState& state,
                                                bool fix_cameras,
                                                bool fix_points) {
  Sizes sizes;
  for (const auto& camera : state.cameras)
    sizes.num_camera_parameters.push_back(camera->NumParameters());
  sizes.num_points = static_cast<int>(state.points.size());
  sizes.num_poses = static_cast<int>(state.rig_from_pattern.size());
  sizes.fix_cameras = fix_cameras;
  sizes.fix_points = fix_points;
  return sizes;
}

NormalEquations::NormalEquations(const Sizes& sizes, int num_threads)
    : sizes_(sizes),
      num_threads_(num_threads),
      first_parameter_{0},
      eliminate_points_(!sizes.fix_points &&
                        3 * sizes.num_points > 6 * sizes.num_poses),
      block_size_(eliminate_points_ ? 3 : 6) {
  if (!sizes.fix_cameras)
    for (const int count : sizes.num_camera_parameters)
      first_parameter_.push_back(first_parameter_.back() + count);
  num_camera_ = first_parameter_.back();
  if (!sizes.fix_cameras)
    num_camera_ +=
        6 * (static_cast<int>(sizes.num_camera_parameters.size()) - 1);
  const int num_blocks = eliminate_points_ ? sizes.num_points : sizes.num_poses;
  const int num_kept = eliminate_points_
                           ? 6 * sizes.num_poses
                           : (sizes.fix_points ? 0 : 3 * sizes.num_points);
  const int size = num_camera_ + num_kept;
  a_.setZero(size, size);
  gradient_.setZero(size);
  v_.assign(num_blocks, Block::Zero(block_size_, block_size_));
  block_gradient_.assign(num_blocks, BlockVector::Zero(block_size_));
  w_.assign(num_blocks, Eigen::MatrixXd::Zero(size, block_size_));
}

void NormalEquations::AddResiduals(
    const std::vector<LinearizedResidual>& residuals, double huber_px) {
  for (const LinearizedResidual& r : residuals) {
    if (!r.residual.valid) continue;
    const Eigen::Vector2d& error = r.residual.error_px;
    const double weight = HuberWeight(error.norm(), huber_px);
    GatheredJacobian jacobian;
    if (!sizes_.fix_cameras) {
      jacobian.AddCamera(first_parameter_[r.camera], r.projection);
      if (r.camera > 0)
        jacobian.Add(first_parameter_.back() + 6 * (r.camera - 1),
                     r.by_camera_pose);
    }
    if (eliminate_points_)
      jacobian.Add(num_camera_ + 6 * r.pose, r.by_pose);
    else if (!sizes_.fix_points)
      jacobian.Add(num_camera_ + 3 * r.point, r.by_point);

    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 6> by_block(2, block_size_);
    if (eliminate_points_)
      by_block = r.by_point;
    else
      by_block = r.by_pose;
    const int block = eliminate_points_ ? r.point : r.pose;
    v_[block].noalias() += weight * by_block.transpose() * by_block;
    block_gradient_[block].noalias() += weight * by_block.transpose() * error;
    for (int i = 0; i < jacobian.count; ++i) {
      const Eigen::Vector2d weighted = weight * jacobian.value.col(i);
      const int row = jacobian.column[i];
      gradient_[row] += weighted.dot(error);
      w_[block].row(row).noalias() += weighted.transpose() * by_block;
      for (int j = 0; j <= i; ++j)
        a_(row, jacobian.column[j]) += weighted.dot(jacobian.value.col(j));
    }
  }
}

void NormalEquations::AddCameraPrior(const CameraPrior& prior, int first,
                                     const Eigen::VectorXd& parameters) {
  const Eigen::VectorXd difference = parameters - prior.mean;
  const Eigen::Index count = difference.size();
  for (const PriorGroup& group : prior.groups) {
    gradient_.segment(first, count) +=
        group.weight * (group.precision * difference);
    for (int k = 0; k < group.precision.outerSize(); ++k)
      for (Eigen::SparseMatrix<double>::InnerIterator it(group.precision, k);
           it; ++it)
        if (it.row() >= it.col())
          a_(first + it.row(), first + it.col()) += group.weight * it.value();
  }
  const Eigen::MatrixXd& g = prior.orientation;
  if (g.cols() == 0) return;
  gradient_.segment(first, count) +=
      prior.orientation_weight * (g * (g.transpose() * difference));
  a_.block(first, first, count, count)
      .selfadjointView<Eigen::Lower>()
      .rankUpdate(g, prior.orientation_weight);
}

void NormalEquations::AddPrior(const GaussianPrior& prior,
                               const AdjustmentState& state) {
  if (!sizes_.fix_cameras)
    for (size_t c = 0; c < prior.cameras.size(); ++c)
      AddCameraPrior(prior.cameras[c], first_parameter_[c],
                     state.cameras[c]->Parameters());
  if (sizes_.fix_points || prior.points_mean.empty()) return;
  for (int i = 0; i < sizes_.num_points; ++i) {
    const Eigen::Vector3d gradient =
        prior.points_weight * (state.points[i] - prior.points_mean[i]);
    if (eliminate_points_) {
      block_gradient_[i] += gradient;
      v_[i].diagonal().array() += prior.points_weight;
    } else {
      const int first = num_camera_ + 3 * i;
      gradient_.segment<3>(first) += gradient;
      a_.diagonal().segment<3>(first).array() += prior.points_weight;
    }
  }
}

bool NormalEquations::Reduce(double lambda, Reduced* reduced) const {
  const int num_blocks = static_cast<int>(v_.size());
  Eigen::MatrixXd weighted(a_.rows(), block_size_ * num_blocks);
  reduced->blocks.resize(num_blocks);
  for (int i = 0; i < num_blocks; ++i) {
    Block v = v_[i];
    v.diagonal() *= 1 + lambda;
    v.diagonal().array() += kDampingFloor;
    reduced->blocks[i].compute(v);
    if (reduced->blocks[i].info() != Eigen::Success) return false;
    if (a_.size() == 0) continue;  // camera and points are fixed
    // W L^-T = (L^-1 W^T)^T
    weighted.middleCols(block_size_ * i, block_size_) =
        reduced->blocks[i].matrixL().solve(w_[i].transpose()).transpose();
  }
  if (a_.size() == 0) return true;
  Eigen::MatrixXd matrix = a_;
  matrix.diagonal() *= 1 + lambda;
  matrix.diagonal().array() += kDampingFloor;
  SubtractProduct(weighted, num_threads_, &matrix);
  reduced->dense.compute(matrix);
  return reduced->dense.info() == Eigen::Success;
}

Eigen::MatrixXd NormalEquations::Eliminated(
    const Reduced& reduced, const Eigen::MatrixXd& dense) const {
  Eigen::MatrixXd eliminated = Eigen::MatrixXd::Zero(
      block_size_ * static_cast<int>(v_.size()), dense.cols());
  if (a_.size() == 0) return eliminated;
  for (size_t i = 0; i < v_.size(); ++i)
    eliminated.middleRows(block_size_ * static_cast<int>(i), block_size_) =
        -reduced.blocks[i].solve(w_[i].transpose() * dense);
  return eliminated;
}

bool NormalEquations::Solve(double lambda, AdjustmentStep* step) const {
  Reduced reduced;
  if (!Reduce(lambda, &reduced)) return false;
  Eigen::VectorXd dense = -gradient_;
  if (dense.size() > 0) {
    for (size_t i = 0; i < v_.size(); ++i)
      dense += w_[i] * reduced.blocks[i].solve(block_gradient_[i]);
    reduced.dense.solveInPlace(dense);
  }
  Eigen::VectorXd eliminated = Eliminated(reduced, dense);
  for (size_t i = 0; i < v_.size(); ++i)
    eliminated.segment(block_size_ * static_cast<int>(i), block_size_) -=
        reduced.blocks[i].solve(block_gradient_[i]);

  const Eigen::VectorXd kept = dense.tail(dense.size() - num_camera_);
  const Eigen::VectorXd& poses = eliminate_points_ ? kept : eliminated;
  for (size_t c = 0; c + 1 < first_parameter_.size(); ++c)
    step->cameras.push_back(dense.segment(
        first_parameter_[c], first_parameter_[c + 1] - first_parameter_[c]));
  for (int first = first_parameter_.back(); first < num_camera_; first += 6)
    step->camera_poses.push_back(dense.segment<6>(first));
  step->points = eliminate_points_ ? eliminated : kept;
  step->poses.resize(sizes_.num_poses);
  for (int i = 0; i < sizes_.num_poses; ++i)
    step->poses[i] = poses.segment<6>(6 * i);
  return dense.allFinite() && eliminated.allFinite();
}

bool NormalEquations::SampleCovariance(int num_samples,
                                       CovarianceSamples* samples) const {
  Reduced reduced;
  if (!Reduce(0, &reduced)) return false;
  std::mt19937 random_bits(1);  // the standard fixes its sequence
  const auto fill_with_signs = [&random_bits](Eigen::MatrixXd* matrix) {
    for (Eigen::Index i = 0; i < matrix->size(); ++i)
      matrix->data()[i] = random_bits() & 1 ? 1 : -1;
  };
  Eigen::MatrixXd dense(a_.rows(), num_samples);
  fill_with_signs(&dense);
  reduced.dense.matrixU().solveInPlace(dense);
  for (size_t c = 0; c + 1 < first_parameter_.size(); ++c)
    samples->cameras.push_back(dense.middleRows(
        first_parameter_[c], first_parameter_[c + 1] - first_parameter_[c]));
  samples->camera_poses = dense.middleRows(
      first_parameter_.back(), num_camera_ - first_parameter_.back());
  samples->points = dense.bottomRows(dense.rows() - num_camera_);
  if (eliminate_points_) {
    Eigen::MatrixXd own(3 * sizes_.num_points, num_samples);
    fill_with_signs(&own);
    for (int i = 0; i < sizes_.num_points; ++i) {
      Eigen::MatrixXd rows = own.middleRows<3>(3 * i);
      reduced.blocks[i].matrixU().solveInPlace(rows);
      own.middleRows<3>(3 * i) = rows;
    }
    samples->points = Eliminated(reduced, dense) + own;
  }
  return dense.allFinite();
}

}  // namespace raygrid
