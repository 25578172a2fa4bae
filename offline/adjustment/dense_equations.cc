#include "adjustment/dense_equations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// Row indices of the Schur complement, and the factor's values in these rows.
struct SparseFactor {
  const std::vector<int>& rows;
  Eigen::MatrixXd values;
};

// *matrix -= sum of factor factor^T, lower triangle, in panels of rows. The
// number of panels does not depend on the number of threads, for deterministic
// results.
void SubtractProducts(const std::vector<SparseFactor>& factors, int num_threads,
                      Eigen::MatrixXd* matrix) {
  constexpr int kPanel = 128;
  const int size = static_cast<int>(matrix->rows());
  const int num_panels = (size + kPanel - 1) / kPanel;
  ParallelFor(num_panels, num_threads, [&](int i) {
    // Processes the longest panels first, which are the last ones.
    const int panel = (num_panels - 1 - i) * kPanel;
    Eigen::MatrixXd product;
    for (const SparseFactor& factor : factors) {
      const std::vector<int>& rows = factor.rows;
      const auto index = [&rows](int row) {
        return std::lower_bound(rows.begin(), rows.end(), row) - rows.begin();
      };
      const Eigen::Index begin = index(panel), end = index(panel + kPanel);
      if (begin == end) continue;
      product.noalias() = factor.values.middleRows(begin, end - begin) *
                          factor.values.topRows(end).transpose();
      for (Eigen::Index column = 0; column < end; ++column) {
        double* to = matrix->col(rows[column]).data();
        const double* from = product.col(column).data();
        for (Eigen::Index row = begin; row < end; ++row)
          to[rows[row]] -= from[row - begin];
      }
    }
  });
}

// w <- w L^-T for a lower triangular matrix L.
void DivideByTransposed(const PoseMatrix& lower,
                        Eigen::Ref<Eigen::MatrixXd> w) {
  for (Eigen::Index i = 0; i < w.cols(); ++i) {
    for (Eigen::Index k = 0; k < i; ++k) w.col(i) -= lower(i, k) * w.col(k);
    w.col(i) /= lower(i, i);
  }
}

// Returns the indices of the nonzero rows.
std::vector<int> NonzeroRows(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  std::vector<int> rows;
  for (int row = 0; row < matrix.rows(); ++row)
    if (!matrix.row(row).isZero(0)) rows.push_back(row);
  return rows;
}

// Returns the cost of the product of a sparse factor with its transpose. Each
// entry of the result is read and written once for all columns of the factor.
double ProductCost(size_t num_rows, int num_columns) {
  constexpr double kColumnsPerAccess = 12;
  return std::pow(static_cast<double>(num_rows), 2) *
         (num_columns + kColumnsPerAccess);
}

// Columns of a residual's Jacobian except those of the control points: the
// camera's global parameters, camera_from_rig, target_from_board, static
// deformation and the kept parameters, in ascending order.
struct OtherColumns {
  static constexpr int kMax = LinearizedProjection::kMaxGlobal + 12 +
                              DeformationModes::kMaxCount + kMaxPerPose;
  int count = 0;
  std::array<int, kMax> index;
  Eigen::Matrix<double, 2, kMax> value;

  template <typename Derived>
  void Add(int first, const Eigen::MatrixBase<Derived>& derivative) {
    for (int k = 0; k < derivative.cols(); ++k) {
      index[count] = first + k;
      value.col(count++) = derivative.col(k);
    }
  }
};

using ByBlock = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxPerPose>;

// *y += factor * x for vectors of the given size.
void AddScaled(double factor, const double* x, int size, double* y) {
  for (int n = 0; n < size; ++n) y[n] += factor * x[n];
}

// Computes J_node^T J_other column by column. Jacobians are stored as pairs,
// since a residual has two rows.
void MultiplyPairs(const double* J_node, int size, const double* others,
                   int num_others, double* product) {
  for (int other = 0; other < num_others; ++other)
    for (int n = 0; n < size; ++n)
      product[size * other + n] = J_node[2 * n] * others[2 * other] +
                                  J_node[2 * n + 1] * others[2 * other + 1];
}

// Contributions of a residual that involve its control points. Uses scalar
// loops, because compiling products of small fixed-size matrices takes half a
// minute.
struct NodeContribution {
  const ViewJacobian& jacobian;
  int column, first;  // residual's column; first camera parameter
  const OtherColumns& others;
  const ByBlock& by_block;
  const Eigen::Vector2d& error;

  // kPerNode is as in WithNumPerNode(). The columns of w belong to the
  // residual's block.
  template <int kPerNode, typename Columns>
  void AddTo(Eigen::MatrixXd* a, Columns* w, Eigen::MatrixXd* gradient) const {
    constexpr int kMax =
        kPerNode > 0 ? kPerNode : LinearizedProjection::kMaxPerNode;
    const int size = kPerNode > 0 ? kPerNode : jacobian.num_per_node;
    const int num_block = static_cast<int>(by_block.cols());
    const double* J_node = &jacobian.J_node(0, column);
    // The Jacobians of all control points differ only in their spline weights.
    double node_node[kMax * kMax], node_error[kMax];
    double node_block[kMax * kMaxPerPose];
    double node_others[kMax * OtherColumns::kMax];
    MultiplyPairs(J_node, size, J_node, size, node_node);
    MultiplyPairs(J_node, size, error.data(), 1, node_error);
    MultiplyPairs(J_node, size, by_block.data(), num_block, node_block);
    MultiplyPairs(J_node, size, others.value.data(), others.count, node_others);
    for (int k = 0; k < jacobian.num_nodes; ++k) {
      const double weight = jacobian.node_weight(k, column);
      const int row = first + jacobian.node_parameter(k, column);
      AddScaled(weight, node_error, size, &(*gradient)(row, 0));
      for (int b = 0; b < num_block; ++b)
        AddScaled(weight, node_block + size * b, size, &(*w)(row, b));
      for (int l = 0; l <= k; ++l) {
        const int other_node = first + jacobian.node_parameter(l, column);
        const double both = weight * jacobian.node_weight(l, column);
        for (int n = 0; n < size; ++n)
          AddScaled(both, node_node + size * n, size,
                    &(*a)(row, other_node + n));
      }
      for (int other = 0; other < others.count; ++other)
        for (int n = 0; n < size; ++n)
          (*a)(others.index[other], row + n) +=
              weight * node_others[size * other + n];
    }
  }
};

}  // namespace

DenseEquations::DenseEquations(const ParameterLayout& layout,
                               const std::vector<ViewJacobian>& jacobians,
                               const DeformationModes& modes,
                               const PriorEquations& prior, int num_threads)
    : layout_(layout),
      num_threads_(num_threads),
      eliminate_points_(3 * layout.num_points >
                        layout.per_pose * layout.num_poses),
      block_size_(eliminate_points_ ? 3 : layout.per_pose) {
  const int num_blocks =
      eliminate_points_ ? layout.num_points : layout.num_poses;
  const int size = eliminate_points_
                       ? layout.first_point + layout.per_pose * layout.num_poses
                       : layout.size;
  a_.setZero(size, size);
  v_.assign(num_blocks, PoseMatrix::Zero(block_size_, block_size_));
  w_.setZero(size, block_size_ * num_blocks);
  gradient_ = {Eigen::MatrixXd::Zero(size, 1),
               Eigen::MatrixXd::Zero(block_size_ * num_blocks, 1)};
  for (const ViewJacobian& jacobian : jacobians) AddJacobian(jacobian, modes);
  if (layout.has_shapes() && layout.num_points > 0)
    AddDeformation(StaticDeformation(layout, modes));
  AddPrior(prior);
  CompressCouplings();
}

void DenseEquations::AddJacobian(const ViewJacobian& jacobian,
                                 const DeformationModes& modes) {
  const bool has_cameras = layout_.has_cameras();
  const int first = has_cameras ? layout_.first_camera[jacobian.camera] : 0;
  const int num_nodes = has_cameras ? jacobian.num_nodes : 0;
  for (int i = 0; i < jacobian.count(); ++i) {
    const ByBlock J_pose = jacobian.PoseJacobian(i).transpose();
    const auto J_point = ViewJacobian::Block<3>(jacobian.J_point, i);
    const int point = jacobian.points[i];
    OtherColumns others;
    if (has_cameras) {
      others.Add(first + jacobian.first_global,
                 ViewJacobian::Block(jacobian.J_global, i));
      if (jacobian.camera > 0)
        others.Add(layout_.CameraPose(jacobian.camera),
                   ViewJacobian::Block<6>(jacobian.J_camera_pose, i));
    }
    if (layout_.has_board_poses() && jacobian.place >= 0)
      others.Add(layout_.Place(jacobian.place),
                 ViewJacobian::Block<6>(jacobian.J_board_pose, i));
    if (layout_.has_shapes() && layout_.num_points == 0)
      others.Add(layout_.Shape(modes.boards[point]),
                 J_point * modes.by_point[point]);
    if (eliminate_points_)
      others.Add(FirstPose() + layout_.per_pose * jacobian.pose, J_pose);
    else if (layout_.num_points > 0)
      others.Add(layout_.Point(point), J_point);

    ByBlock by_block(2, block_size_);
    if (eliminate_points_)
      by_block = J_point;
    else
      by_block = J_pose;
    const int block = eliminate_points_ ? point : jacobian.pose;
    auto w = w_.middleCols(block_size_ * block, block_size_);
    const Eigen::Vector2d error = jacobian.error.col(i);
    v_[block].noalias() += by_block.transpose() * by_block;
    gradient_.eliminated.middleRows(block_size_ * block, block_size_)
        .noalias() += by_block.transpose() * error;
    for (int a = 0; a < others.count; ++a) {
      const int row = others.index[a];
      gradient_.kept(row) += others.value.col(a).dot(error);
      w.row(row).noalias() += others.value.col(a).transpose() * by_block;
      for (int b = 0; b <= a; ++b)
        a_(row, others.index[b]) +=
            others.value.col(a).dot(others.value.col(b));
    }

    const NodeContribution products = {jacobian, i,        first,
                                       others,   by_block, error};
    WithNumPerNode(num_nodes == 0 ? 0 : jacobian.num_per_node,
                   [&](auto per_node) {
                     products.AddTo<per_node>(&a_, &w, &gradient_.kept);
                   });
  }
}

void DenseEquations::AddDeformation(const StaticDeformation& moves) {
  const Eigen::Index at = layout_.first_shape, num = moves.NumModes();
  if (eliminate_points_) {
    moves.ForEachPoint([&](int point, int bend, const auto& move) {
      w_.block(at + bend, 3 * point, move.cols(), 3).noalias() =
          move.transpose() * v_[point];
    });
    gradient_.kept.middleRows(at, num) =
        moves.ComputeModeGradient(gradient_.eliminated);
    const Eigen::MatrixXd mode_gradient =
        moves.ComputeModeGradient(w_.transpose());
    const Eigen::Index end = at + num, behind = a_.rows() - end;
    a_.block(at, 0, num, end) = mode_gradient.leftCols(end);
    a_.block(end, at, behind, num) =
        mode_gradient.rightCols(behind).transpose();
    return;
  }
  const Eigen::Index first = layout_.first_point;
  const Eigen::Index count = layout_.size - first;
  w_.middleRows(at, num) = moves.ComputeModeGradient(w_.bottomRows(count));
  gradient_.kept.middleRows(at, num) =
      moves.ComputeModeGradient(gradient_.kept.bottomRows(count));
  a_.block(at, 0, num, at) =
      moves.ComputeModeGradient(a_.block(first, 0, count, at));
  moves.ForEachPoint([&](int point, int bend, const auto& move) {
    const Eigen::Index row = layout_.Point(point);
    a_.block(row, at + bend, 3, move.cols()).noalias() =
        a_.block<3, 3>(row, row).selfadjointView<Eigen::Lower>() * move;
  });
  a_.block(at, at, num, num) =
      moves.ComputeModeGradient(a_.block(first, at, count, num));
}

void DenseEquations::AddPrior(const PriorEquations& prior) {
  const int num_common = NumCommon();
  gradient_.kept.topRows(num_common) += prior.gradient.head(num_common);
  for (int k = 0; k < prior.precision.outerSize(); ++k) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(prior.precision, k); it;
         ++it) {
      if (it.row() < it.col()) continue;
      if (it.row() < num_common) {
        a_(it.row(), it.col()) += it.value();
      } else {
        const Eigen::Index row = it.row() - num_common;
        v_[row / 3](row % 3, row % 3) += it.value();
      }
    }
  }
  if (eliminate_points_)
    gradient_.eliminated += prior.gradient.tail(3 * layout_.num_points);
  const Eigen::Index num_modes = prior.deformation_precision.size();
  for (int pose = 0; pose < layout_.num_poses && num_modes > 0; ++pose) {
    const Eigen::Index flex = FirstPose() + layout_.per_pose * pose + 6;
    if (eliminate_points_)
      a_.diagonal().segment(flex, num_modes) += prior.deformation_precision;
    else
      v_[pose].diagonal().tail(num_modes) += prior.deformation_precision;
    (eliminate_points_ ? gradient_.kept : gradient_.eliminated)
        .middleRows(flex, num_modes) += prior.deformation_gradient.col(pose);
  }
  const auto add_product = [&](const Eigen::MatrixXd& root, double sign) {
    if (num_common > 0 && root.cols() > 0)
      a_.topLeftCorner(num_common, num_common)
          .selfadjointView<Eigen::Lower>()
          .rankUpdate(root.topRows(num_common), sign);
  };
  add_product(prior.root, 1);
  add_product(prior.unpenalized, -1);
}

void DenseEquations::CompressCouplings() {
  for (int block = 0; block < static_cast<int>(v_.size()); ++block) {
    std::vector<int> rows =
        NonzeroRows(w_.middleCols(block_size_ * block, block_size_));
    if (!couplings_.empty()) {
      Coupling& last = couplings_.back();
      std::vector<int> both;
      std::set_union(last.rows.begin(), last.rows.end(), rows.begin(),
                     rows.end(), std::back_inserter(both));
      const int num_columns = block_size_ * last.num_blocks;
      if (ProductCost(both.size(), num_columns + block_size_) <=
          ProductCost(last.rows.size(), num_columns) +
              ProductCost(rows.size(), block_size_)) {
        last.rows = std::move(both);
        ++last.num_blocks;
        continue;
      }
    }
    couplings_.push_back({block, 1, std::move(rows), {}});
  }
  for (Coupling& coupling : couplings_)
    coupling.w =
        w_(coupling.rows, Eigen::seqN(block_size_ * coupling.first_block,
                                      block_size_ * coupling.num_blocks));
  w_.resize(0, 0);
}

bool DenseEquations::Reduce(double lambda, Reduced* reduced) const {
  reduced->blocks.resize(v_.size());
  for (size_t i = 0; i < v_.size(); ++i) {
    PoseMatrix v = v_[i];
    v.diagonal() *= 1 + lambda;
    v.diagonal().array() += kDampingFloor;
    reduced->blocks[i].compute(v);
    if (reduced->blocks[i].info() != Eigen::Success) return false;
  }
  if (a_.size() == 0) return true;  // cameras and points are fixed
  std::vector<SparseFactor> weighted;
  for (const Coupling& coupling : couplings_) {
    weighted.push_back({coupling.rows, coupling.w});
    for (int i = 0; i < coupling.num_blocks; ++i)
      DivideByTransposed(
          reduced->blocks[coupling.first_block + i].matrixLLT(),
          weighted.back().values.middleCols(block_size_ * i, block_size_));
  }
  Eigen::MatrixXd matrix = a_;
  matrix.diagonal() *= 1 + lambda;
  matrix.diagonal().array() += kDampingFloor;
  SubtractProducts(weighted, num_threads_, &matrix);
  reduced->dense.compute(matrix);
  return reduced->dense.info() == Eigen::Success;
}

const DenseEquations::Reduced* DenseEquations::ReducedFor(double lambda) const {
  if (lambda != last_lambda_)
    last_lambda_ = Reduce(lambda, &last_) ? lambda : -1;
  return last_lambda_ == lambda ? &last_ : nullptr;
}

DenseEquations::Columns DenseEquations::Solution(const Reduced& reduced,
                                                 Columns right) const {
  const auto solve_blocks = [&](Eigen::MatrixXd* sides) {
    for (size_t i = 0; i < v_.size(); ++i) {
      auto own =
          sides->middleRows(block_size_ * static_cast<int>(i), block_size_);
      own = reduced.blocks[i].solve(own.eval());
    }
  };
  Eigen::MatrixXd eliminated = right.eliminated;
  solve_blocks(&eliminated);
  if (a_.size() > 0) {
    const auto get_columns = [this](const Coupling& coupling) {
      return Eigen::seqN(block_size_ * coupling.first_block,
                         block_size_ * coupling.num_blocks);
    };
    for (const Coupling& coupling : couplings_)
      right.kept(coupling.rows, Eigen::all) -=
          coupling.w * eliminated(get_columns(coupling), Eigen::all);
    reduced.dense.solveInPlace(right.kept);
    for (const Coupling& coupling : couplings_)
      right.eliminated(get_columns(coupling), Eigen::all) -=
          coupling.w.transpose() * right.kept(coupling.rows, Eigen::all);
  }
  solve_blocks(&right.eliminated);
  return right;
}

bool DenseEquations::Solve(double lambda, AdjustmentStep* step) const {
  const Reduced* reduced = ReducedFor(lambda);
  if (!reduced) return false;
  const Columns solution =
      Solution(*reduced, {-gradient_.kept, -gradient_.eliminated});
  if (eliminate_points_) {
    Eigen::VectorXd parameters(layout_.size);
    parameters << solution.kept.topRows(layout_.first_point),
        solution.eliminated;
    *step = layout_.UnpackStep(
        parameters,
        solution.kept.bottomRows(layout_.per_pose * layout_.num_poses));
  } else {
    *step = layout_.UnpackStep(solution.kept, solution.eliminated);
  }
  return solution.kept.allFinite() && solution.eliminated.allFinite();
}

bool DenseEquations::SolveFor(double lambda, const Eigen::MatrixXd& right,
                              Eigen::MatrixXd* solution) const {
  const Reduced* reduced = ReducedFor(lambda);
  if (!reduced) return false;
  Columns columns = {
      Eigen::MatrixXd::Zero(a_.rows(), right.cols()),
      Eigen::MatrixXd::Zero(gradient_.eliminated.rows(), right.cols())};
  const int num_common = NumCommon();
  const Eigen::Index num_poses = right.rows() - layout_.size;  // 0 or all
  columns.kept.topRows(num_common) = right.topRows(num_common);
  if (eliminate_points_)
    columns.eliminated =
        right.middleRows(layout_.first_point, 3 * layout_.num_points);
  (eliminate_points_ ? columns.kept : columns.eliminated)
      .middleRows(FirstPose(), num_poses) = right.bottomRows(num_poses);
  columns = Solution(*reduced, std::move(columns));
  solution->resize(right.rows(), right.cols());
  solution->topRows(num_common) = columns.kept.topRows(num_common);
  if (eliminate_points_)
    solution->middleRows(layout_.first_point, 3 * layout_.num_points) =
        columns.eliminated;
  solution->bottomRows(num_poses) =
      (eliminate_points_ ? columns.kept : columns.eliminated)
          .middleRows(FirstPose(), num_poses);
  return solution->allFinite();
}

int NumDenseUnknowns(const ParameterLayout& layout) {
  return std::min(layout.first_point + layout.per_pose * layout.num_poses,
                  layout.size);
}

bool DenseIsFaster(const ParameterLayout& layout, double large_operations) {
  constexpr double kSmall = 1100;  // always faster below this size
  if (!layout.has_cameras()) return true;
  const double kept = NumDenseUnknowns(layout);
  const double eliminated =
      layout.size + layout.per_pose * layout.num_poses - kept;
  return kept <= kSmall ||
         kept * kept * (eliminated + kept / 3) < large_operations;
}

}  // namespace raygrid
