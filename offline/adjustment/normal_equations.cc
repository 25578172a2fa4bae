#include "adjustment/normal_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <random>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// The columns of a residual's Jacobian by camera and points, gathered.
struct GatheredJacobian {
  static constexpr int kMax = LinearizedProjection::kMaxParameters + 3;
  int count = 0;
  std::array<int, kMax> column;
  Eigen::Matrix<double, 2, kMax> value;

  void Add(int index, const Eigen::Vector2d& derivative) {
    column[count] = index;
    value.col(count++) = derivative;
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

NormalEquations::NormalEquations(int num_camera_parameters, int num_points,
                                 int num_views, bool fix_camera,
                                 bool fix_points, int num_threads)
    : num_camera_(fix_camera ? 0 : num_camera_parameters),
      num_point_parameters_(fix_points ? 0 : 3 * num_points),
      fix_camera_(fix_camera),
      fix_points_(fix_points),
      num_threads_(num_threads) {
  const int size = num_camera_ + num_point_parameters_;
  a_.setZero(size, size);
  gradient_.setZero(size);
  v_.assign(num_views, Matrix6d::Zero());
  pose_gradient_.assign(num_views, Eigen::Matrix<double, 6, 1>::Zero());
  w_.assign(num_views, Eigen::MatrixXd::Zero(size, 6));
}

void NormalEquations::AddResiduals(
    const std::vector<LinearizedResidual>& residuals, double huber_px) {
  for (const LinearizedResidual& r : residuals) {
    if (!r.residual.valid) continue;
    const Eigen::Vector2d& error = r.residual.error_px;
    const double weight = HuberWeight(error.norm(), huber_px);
    GatheredJacobian jacobian;
    if (!fix_camera_)
      for (int k = 0; k < r.projection.num_parameters; ++k)
        jacobian.Add(r.projection.parameter_index[k],
                     r.projection.by_parameter.col(k));
    if (!fix_points_)
      for (int k = 0; k < 3; ++k)
        jacobian.Add(num_camera_ + 3 * r.point + k, r.by_point.col(k));

    const Eigen::Matrix<double, 6, 2> pose_t = weight * r.by_pose.transpose();
    v_[r.view].noalias() += pose_t * r.by_pose;
    pose_gradient_[r.view].noalias() += pose_t * error;
    for (int i = 0; i < jacobian.count; ++i) {
      const Eigen::Vector2d weighted = weight * jacobian.value.col(i);
      const int row = jacobian.column[i];
      gradient_[row] += weighted.dot(error);
      w_[r.view].row(row).noalias() += weighted.transpose() * r.by_pose;
      for (int j = 0; j <= i; ++j)  // columns ascend
        a_(row, jacobian.column[j]) += weighted.dot(jacobian.value.col(j));
    }
  }
}

void NormalEquations::AddPrior(const GaussianPrior& prior,
                               const AdjustmentState& state) {
  if (!fix_camera_ && prior.camera_mean.size() == num_camera_) {
    const Eigen::VectorXd difference =
        state.camera->Parameters() - prior.camera_mean;
    gradient_.head(num_camera_) +=
        prior.camera_weight * (prior.camera_precision * difference);
    for (int k = 0; k < prior.camera_precision.outerSize(); ++k)
      for (Eigen::SparseMatrix<double>::InnerIterator it(prior.camera_precision,
                                                         k);
           it; ++it)
        if (it.row() >= it.col())
          a_(it.row(), it.col()) += prior.camera_weight * it.value();
    const Eigen::MatrixXd& g = prior.orientation;
    gradient_.head(num_camera_) +=
        prior.orientation_weight * (g * (g.transpose() * difference));
    a_.topLeftCorner(num_camera_, num_camera_)
        .selfadjointView<Eigen::Lower>()
        .rankUpdate(g, prior.orientation_weight);
  }
  if (fix_points_) return;
  for (size_t i = 0; i < prior.points_mean.size(); ++i) {
    const Eigen::Index first = num_camera_ + 3 * static_cast<Eigen::Index>(i);
    gradient_.segment<3>(first) +=
        prior.points_weight * (state.points[i] - prior.points_mean[i]);
    for (int k = 0; k < 3; ++k) a_(first + k, first + k) += prior.points_weight;
  }
}

bool NormalEquations::Reduce(double lambda, Eigen::MatrixXd* reduced,
                             Eigen::VectorXd* right, Eigen::MatrixXd* weighted,
                             std::vector<Eigen::LLT<Matrix6d>>* factors) const {
  const int size = static_cast<int>(a_.rows());
  const int num_views = static_cast<int>(v_.size());
  weighted->resize(size, 6 * num_views);
  factors->resize(num_views);
  *right = -gradient_;
  for (int i = 0; i < num_views; ++i) {
    Matrix6d v = v_[i];
    v.diagonal() += lambda * v.diagonal();
    v.diagonal().array() += kDampingFloor;
    (*factors)[i].compute(v);
    if ((*factors)[i].info() != Eigen::Success) return false;
    // W L^-T = (L^-1 W^T)^T
    weighted->middleCols<6>(6 * i) =
        (*factors)[i].matrixL().solve(w_[i].transpose()).transpose();
    right->noalias() += w_[i] * (*factors)[i].solve(pose_gradient_[i]);
  }
  *reduced = a_;
  reduced->diagonal() += lambda * a_.diagonal();
  reduced->diagonal().array() += kDampingFloor;
  SubtractProduct(*weighted, num_threads_, reduced);
  return true;
}

bool NormalEquations::Solve(double lambda, AdjustmentStep* step) const {
  Eigen::MatrixXd reduced, weighted;
  Eigen::VectorXd right;
  std::vector<Eigen::LLT<Matrix6d>> factors;
  if (!Reduce(lambda, &reduced, &right, &weighted, &factors)) return false;
  Eigen::VectorXd solution(right.size());
  if (right.size() > 0) {
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(reduced);
    if (llt.info() != Eigen::Success) return false;
    solution = llt.solve(right);
  }
  step->camera = solution.head(num_camera_);
  step->points = solution.tail(num_point_parameters_);
  step->poses.resize(v_.size());
  for (size_t i = 0; i < v_.size(); ++i)
    step->poses[i] =
        factors[i].solve(-pose_gradient_[i] - w_[i].transpose() * solution);
  return solution.allFinite();
}

bool NormalEquations::CovarianceSamples(int num_samples,
                                        Eigen::MatrixXd* samples) const {
  Eigen::MatrixXd reduced, weighted;
  Eigen::VectorXd right;
  std::vector<Eigen::LLT<Matrix6d>> factors;
  if (!Reduce(0, &reduced, &right, &weighted, &factors)) return false;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(reduced);
  if (llt.info() != Eigen::Success) return false;
  std::mt19937 random_bits(1);  // the standard fixes its sequence
  samples->resize(reduced.rows(), num_samples);
  for (Eigen::Index i = 0; i < samples->size(); ++i)
    samples->data()[i] = random_bits() & 1 ? 1 : -1;
  llt.matrixU().solveInPlace(*samples);
  return samples->allFinite();
}

}  // namespace raygrid
