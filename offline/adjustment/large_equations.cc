#include "adjustment/large_equations.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "adjustment/coarse_basis.h"
#include "adjustment/node_blocks.h"
#include "adjustment/node_products.h"
#include "adjustment/residual_product.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr int kMaxIterations = 300;
// A preconditioner is recomputed once it needs more than twice the iterations
// that it needed when new, plus this number.
constexpr int kMaxWorse = 6;

}  // namespace

LargeEquations::LargeEquations(const ParameterLayout& layout,
                               std::vector<ViewJacobian> jacobians,
                               const PriorEquations& prior,
                               const AdjustmentState& state, double tolerance,
                               int num_threads,
                               std::shared_ptr<Workspace> memory)
    : layout_(layout),
      static_deformation_(layout, state.modes),
      jacobians_(std::move(jacobians)),
      prior_(prior),
      points_(state.points),
      frames_(NodeFrames(layout, state)),
      tolerance_(tolerance),
      num_threads_(num_threads),
      shapes_(layout.first_camera.size() - 1),
      poses_(layout.num_poses),
      workspace_(std::move(memory)) {
  for (size_t v = 0; v < jacobians_.size(); ++v) {
    const int camera = jacobians_[v].camera;
    poses_[jacobians_[v].pose].views.push_back(static_cast<int>(v));
    if (shapes_[camera].per_node == 0)
      shapes_[camera] =
          InferGridShape(jacobians_[v], layout_.NumCameraParameters(camera));
  }
  AccumulatePoses();
  if (workspace_->diagonal.size() != layout_.size) *workspace_ = Workspace();
  workspace_->local.resize(0, 0);  // invalid for new equations
  if (workspace_->diagonal.size() == 0) {
    workspace_->local = LocalMatrix();
    workspace_->diagonal = workspace_->local.diagonal();
  }
}

// Returns the number of chunks. It does not depend on the number of threads,
// and the results of chunks are added in order, for deterministic results.
int LargeEquations::NumChunks() const {
  return std::min<int>(16, static_cast<int>(poses_.size()));
}

int LargeEquations::ChunkBegin(int chunk) const {
  return static_cast<int>(poses_.size()) * chunk / NumChunks();
}

template <int kNum, typename Body>
Columns<kNum> LargeEquations::SumOverPoses(const Body& body) const {
  std::vector<Columns<kNum>> sums(NumChunks());
  ParallelFor(NumChunks(), num_threads_, [&](int chunk) {
    sums[chunk].setZero(static_deformation_.moved().size, kNum);
    for (int p = ChunkBegin(chunk); p < ChunkBegin(chunk + 1); ++p)
      body(p, &sums[chunk]);
  });
  for (size_t chunk = 1; chunk < sums.size(); ++chunk) sums[0] += sums[chunk];
  if (sums.empty()) return Columns<kNum>::Zero(layout_.size, kNum);
  return static_deformation_.MapToModes(sums[0]);
}

void LargeEquations::AccumulatePoses() {
  gradient_ =
      prior_.gradient + SumOverPoses<1>([&](int p, Eigen::VectorXd* sum) {
        PoseBlock& pose = poses_[p];
        pose.v.setZero(layout_.per_pose, layout_.per_pose);
        pose.gradient.setZero(layout_.per_pose);
        const Eigen::Index num_modes = prior_.deformation_precision.size();
        pose.v.diagonal().tail(num_modes) = prior_.deformation_precision;
        if (num_modes > 0)
          pose.gradient.tail(num_modes) = prior_.deformation_gradient.col(p);
        for (const int v : pose.views) {
          const ViewJacobian& j = jacobians_[v];
          if (j.count() == 0) continue;
          pose.v.noalias() += j.J_pose * j.J_pose.transpose();
          pose.gradient.noalias() += j.J_pose * j.error.reshaped();
          const ResidualProduct product(static_deformation_.moved(), j);
          for (int i = 0; i < j.count(); ++i)
            product.AddTransposed<1>(j.error.col(i), i, sum);
        }
      });
}

// Returns the entries of A that the preconditioner uses: couplings between
// control points, the diagonal blocks of the points, and the diagonal for all
// remaining parameters.
Eigen::SparseMatrix<double> LargeEquations::LocalMatrix() const {
  std::vector<Eigen::Triplet<double>> triplets;
  constexpr int kBandRows = 8;  // exceeds the support of a residual, 4
  for (size_t c = 0; c < shapes_.size(); ++c) {
    const GridShape& shape = shapes_[c];
    if (shape.per_node == 0) continue;
    struct Place {
      int view, column;
    };
    std::vector<std::vector<Place>> bands(shape.rows / kBandRows + 1);
    for (size_t v = 0; v < jacobians_.size(); ++v) {
      const ViewJacobian& j = jacobians_[v];
      if (j.camera != static_cast<int>(c)) continue;
      for (int i = 0; i < j.count(); ++i)
        bands[j.node_parameter(0, i) / (shape.per_node * shape.columns) /
              kBandRows]
            .push_back({static_cast<int>(v), i});
    }
    NodeProducts products(shape);
    for (int parity = 0; parity < 2; ++parity)
      ParallelFor((static_cast<int>(bands.size()) + 1 - parity) / 2,
                  num_threads_, [&](int i) {
                    for (const Place& place : bands[2 * i + parity])
                      products.Add(jacobians_[place.view], place.column);
                  });
    products.AppendTo(layout_.first_camera[c], &triplets);
  }
  for (const ViewJacobian& j : jacobians_) {
    const int first = layout_.first_camera[j.camera];
    for (int i = 0; i < j.count(); ++i) {
      for (int k = 0; k < j.num_global; ++k) {
        const int index = first + j.first_global + k;
        triplets.emplace_back(
            index, index,
            ViewJacobian::Block(j.J_global, i).col(k).squaredNorm());
      }
      for (int k = 0; j.camera > 0 && k < 6; ++k) {
        const int index = layout_.CameraPose(j.camera) + k;
        triplets.emplace_back(
            index, index,
            ViewJacobian::Block<6>(j.J_camera_pose, i).col(k).squaredNorm());
      }
      for (int k = 0; j.place >= 0 && k < 6; ++k) {
        const int index = layout_.Place(j.place) + k;
        triplets.emplace_back(
            index, index,
            ViewJacobian::Block<6>(j.J_board_pose, i).col(k).squaredNorm());
      }
    }
  }
  const int num_points = static_deformation_.moved().num_points;
  if (num_points > 0) {
    std::vector<Eigen::Matrix3d> blocks(num_points, Eigen::Matrix3d::Zero());
    for (const ViewJacobian& j : jacobians_)
      for (int i = 0; i < j.count(); ++i) {
        const auto J_point = ViewJacobian::Block<3>(j.J_point, i);
        blocks[j.points[i]].noalias() += J_point.transpose() * J_point;
      }
    for (int i = 0; i < layout_.num_points; ++i)
      for (int k = 0; k < 9; ++k)
        triplets.emplace_back(layout_.Point(i) + k % 3,
                              layout_.Point(i) + k / 3, blocks[i].data()[k]);
    static_deformation_.ForEachPoint(
        [&](int point, int bend, const auto& move) {
          for (Eigen::Index k = 0; k < move.cols(); ++k) {
            const int index = layout_.first_shape + bend + static_cast<int>(k);
            triplets.emplace_back(index, index,
                                  move.col(k).dot(blocks[point] * move.col(k)));
          }
        });
  }
  Eigen::SparseMatrix<double> matrix(layout_.size, layout_.size);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

bool LargeEquations::MakeSystem(double lambda, System* system) const {
  system->lambda = lambda;
  system->damping =
      lambda * (workspace_->diagonal + prior_.precision.diagonal() +
                prior_.root.rowwise().squaredNorm() -
                prior_.unpenalized.rowwise().squaredNorm());
  system->damping.array() += kDampingFloor;
  for (const PoseBlock& pose : poses_) {
    PoseMatrix v = pose.v;
    v.diagonal() *= 1 + lambda;
    v.diagonal().array() += kDampingFloor;
    system->poses.emplace_back(v);
    if (system->poses.back().info() != Eigen::Success) return false;
  }
  return true;
}

template <int kNum>
Columns<kNum> LargeEquations::Apply(const System& system,
                                    const Columns<kNum>& x) const {
  const Columns<kNum> moved = static_deformation_.MapToPoints(x);
  Columns<kNum> y = SumOverPoses<kNum>([&](int p, Columns<kNum>* sum) {
    const std::vector<int>& views = poses_[p].views;
    std::vector<Columns<kNum>> images;  // products with x, by view
    Eigen::Matrix<double, Eigen::Dynamic, kNum, 0, kMaxPerPose, kNum> pose;
    pose.setZero(layout_.per_pose, kNum);
    for (const int v : views) {
      const ViewJacobian& j = jacobians_[v];
      Columns<kNum>& u = images.emplace_back(2 * j.count(), kNum);
      const ResidualProduct product(static_deformation_.moved(), j);
      for (int i = 0; i < j.count(); ++i)
        u.template middleRows<2>(2 * i) = product.Times<kNum>(moved, i);
      if (j.count() > 0) pose.noalias() += j.J_pose * u;
    }
    system.poses[p].solveInPlace(pose);
    for (size_t k = 0; k < views.size(); ++k) {
      const ViewJacobian& j = jacobians_[views[k]];
      Columns<kNum>& u = images[k];
      if (j.count() > 0) u.noalias() -= j.J_pose.transpose() * pose;
      const ResidualProduct product(static_deformation_.moved(), j);
      for (int i = 0; i < j.count(); ++i)
        product.AddTransposed<kNum>(u.template middleRows<2>(2 * i), i, sum);
    }
  });
  y += prior_.Times(x) + system.damping.asDiagonal() * x;
  return y;
}

Eigen::MatrixXd LargeEquations::CoarseMatrix(
    const System& system, const Preconditioner& preconditioner) const {
  const auto& coarse_basis = preconditioner.basis;
  const ParameterLayout& moved = static_deformation_.moved();
  const CoarseBasis moved_basis = static_deformation_.MapToPoints(coarse_basis);
  const int size = static_cast<int>(coarse_basis.cols());
  std::vector<Eigen::MatrixXd> sums(NumChunks());
  ParallelFor(NumChunks(), num_threads_, [&](int chunk) {
    Eigen::MatrixXd& sum = sums[chunk];
    sum.setZero(size, size);
    SparseRow row(moved_basis);
    Eigen::MatrixXd with_pose(size, layout_.per_pose);
    for (int p = ChunkBegin(chunk); p < ChunkBegin(chunk + 1); ++p) {
      with_pose.setZero();
      for (const int v : poses_[p].views) {
        const ViewJacobian& j = jacobians_[v];
        const int first = layout_.first_camera[j.camera];
        for (int i = 0; i < j.count(); ++i) {
          const auto J_node = ViewJacobian::Block(j.J_node, i);
          for (int k = 0; k < j.num_nodes; ++k)
            for (int c = 0; c < j.num_per_node; ++c)
              row.Add(first + j.node_parameter(k, i) + c,
                      j.node_weight(k, i) * J_node.col(c));
          for (int c = 0; c < j.num_global; ++c)
            row.Add(first + j.first_global + c,
                    ViewJacobian::Block(j.J_global, i).col(c));
          for (int c = 0; j.camera > 0 && c < 6; ++c)
            row.Add(moved.CameraPose(j.camera) + c,
                    ViewJacobian::Block<6>(j.J_camera_pose, i).col(c));
          for (int c = 0; j.place >= 0 && c < 6; ++c)
            row.Add(moved.Place(j.place) + c,
                    ViewJacobian::Block<6>(j.J_board_pose, i).col(c));
          for (int c = 0; moved.num_points > 0 && c < 3; ++c)
            row.Add(moved.Point(j.points[i]) + c,
                    ViewJacobian::Block<3>(j.J_point, i).col(c));
          row.AddProductsTo(j.PoseJacobian(i).transpose(), &sum, &with_pose);
          row.Clear();
        }
      }
      // W V^-1 W^T = (L^-1 W^T)^T (L^-1 W^T)
      const Eigen::MatrixXd half =
          system.poses[p].matrixL().solve(with_pose.transpose());
      sum.selfadjointView<Eigen::Lower>().rankUpdate(half.transpose(), -1);
    }
  });
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (const Eigen::MatrixXd& sum : sums) matrix += sum;
  const Eigen::SparseMatrix<double> basis = coarse_basis;
  const Eigen::SparseMatrix<double> prior =
      basis.transpose() * (prior_.precision * basis);
  const Eigen::SparseMatrix<double> damping =
      basis.transpose() * (system.damping.asDiagonal() * basis);
  matrix += Eigen::MatrixXd(prior) + Eigen::MatrixXd(damping);
  const Eigen::MatrixXd root = basis.transpose() * prior_.root;
  const Eigen::MatrixXd unpenalized = basis.transpose() * prior_.unpenalized;
  matrix += root * root.transpose() - unpenalized * unpenalized.transpose();
  return matrix;  // lower triangle only
}

LargeEquations::CameraMultigrid LargeEquations::MakeMultigridLevels(
    int camera, const Eigen::SparseMatrix<double>& a) const {
  CameraMultigrid levels;
  const GridShape& shape = shapes_[camera];
  const int k = shape.per_node;
  levels.first = layout_.first_camera[camera];
  levels.inverse.setZero(k, shape.num_parameters());
  for (int i = 0; i < shape.num_parameters(); ++i)
    for (int p = 0; p < k; ++p)
      levels.inverse(p, i) =
          a.coeff(levels.first + i / k * k + p, levels.first + i);
  InvertNodeBlocks(&levels.inverse);
  GridShape coarse = shape;
  while (std::max(coarse.columns, coarse.rows) - 3 > 2 * kCoarsestCells) {
    coarse = coarse.Halved();
    levels.levels.push_back({GridTransfer(shape, coarse), {}});
  }
  ParallelFor(static_cast<int>(levels.levels.size()), num_threads_, [&](int l) {
    Level& level = levels.levels[l];
    level.inverse = CoarseBlocks(shape, level.transfer, levels.first, a);
    InvertNodeBlocks(&level.inverse);
  });
  return levels;
}

bool LargeEquations::MakePreconditioner(const System& system,
                                        Preconditioner* preconditioner) const {
  Eigen::SparseMatrix<double> a;
  if (workspace_->local.size() > 0)
    a.swap(workspace_->local);
  else
    a = LocalMatrix();
  workspace_->diagonal = a.diagonal();
  a += prior_.precision;
  a.diagonal() += system.damping;
  a = frames_.TransformNodes(a);
  preconditioner->frames = frames_;
  preconditioner->cameras.clear();
  for (size_t c = 0; c < shapes_.size(); ++c)
    if (shapes_[c].per_node > 0)
      preconditioner->cameras.push_back(
          MakeMultigridLevels(static_cast<int>(c), a));
  preconditioner->points.resize(3, 3 * layout_.num_points);
  for (int i = 0; i < 3 * layout_.num_points; ++i)
    for (int k = 0; k < 3; ++k)
      preconditioner->points(k, i) =
          a.coeff(layout_.Point(i / 3) + k, layout_.first_point + i);
  InvertBlocks<Eigen::Matrix3d>(&preconditioner->points);
  preconditioner->basis = frames_.FromNodeFrames(
      MakeCoarseBasis(layout_, shapes_, jacobians_, points_));
  preconditioner->coarse.compute(CoarseMatrix(system, *preconditioner));
  return preconditioner->coarse.info() == Eigen::Success;
}

template <int kNum>
Columns<kNum> LargeEquations::Precondition(
    const Preconditioner& preconditioner, const Columns<kNum>& residual) const {
  const Eigen::MatrixXd coarsest =
      preconditioner.coarse.solve(preconditioner.basis.transpose() * residual);
  Columns<kNum> result = preconditioner.basis * coarsest;
  const Columns<kNum> in_node_frames =
      preconditioner.frames.ToNodeFrames(residual);
  Columns<kNum> sum = Columns<kNum>::Zero(residual.rows(), kNum);
  for (const CameraMultigrid& camera : preconditioner.cameras) {
    const double* from = in_node_frames.data() + kNum * camera.first;
    double* to = sum.data() + kNum * camera.first;
    AddBlockProduct<kNum>(camera.inverse, from, to);
    for (const Level& level : camera.levels) {
      const Eigen::VectorXd coarse = level.transfer.Restrict(kNum, from);
      Eigen::VectorXd product = Eigen::VectorXd::Zero(coarse.size());
      AddBlockProduct<kNum>(level.inverse, coarse.data(), product.data());
      level.transfer.AddProlongation(kNum, product.data(), to);
    }
  }
  result += preconditioner.frames.FromNodeFrames(sum);
  AddBlockProduct<kNum>(preconditioner.points,
                        residual.data() + kNum * layout_.first_point,
                        result.data() + kNum * layout_.first_point);
  return result;
}

template <int kNum>
bool LargeEquations::ConjugateGradients(const System& system, bool is_started,
                                        Columns<kNum>* side,
                                        Columns<kNum>* x) const {
  using PerColumn = Eigen::Array<double, 1, kNum>;
  const Preconditioner& preconditioner = *workspace_->preconditioner;
  Columns<kNum>& residual = *side;
  const auto dot = [](const Columns<kNum>& a,
                      const Columns<kNum>& b) -> PerColumn {
    return a.cwiseProduct(b).colwise().sum();
  };
  Columns<kNum> z = Precondition<kNum>(preconditioner, residual);
  PerColumn product = dot(residual, z);
  const PerColumn target = tolerance_ * tolerance_ * product;
  if (is_started) {
    residual -= Apply<kNum>(system, *x);
    z = Precondition<kNum>(preconditioner, residual);
    product = dot(residual, z);
  } else {
    x->setZero(residual.rows(), kNum);
  }
  Columns<kNum> direction = z;
  int iterations = 0;
  for (; iterations < kMaxIterations && (product > target).any();
       ++iterations) {
    const Columns<kNum> image = Apply<kNum>(system, direction);
    const PerColumn curvature = dot(direction, image);
    // A converged solution remains unchanged, so that the columns do not affect
    // each other.
    const Eigen::Array<bool, 1, kNum> is_open = product > target;
    if ((is_open && !(curvature > 0)).any()) return false;
    const PerColumn length = is_open.select(product / curvature, 0.0);
    x->array() += direction.array().rowwise() * length;
    residual.array() -= image.array().rowwise() * length;
    z = Precondition<kNum>(preconditioner, residual);
    const PerColumn next = dot(residual, z);
    const PerColumn part = is_open.select(next / product, 0.0);
    direction = z.array() + direction.array().rowwise() * part;
    product = next;
  }
  if (!is_started) workspace_->last_iterations_ = iterations;
  return x->allFinite();
}

template <int kNum>
bool LargeEquations::SolveColumns(const System& system, bool is_started,
                                  Eigen::Index first, Eigen::MatrixXd* sides,
                                  Eigen::MatrixXd* x) const {
  Workspace& memory = *workspace_;
  const bool is_new =
      !memory.preconditioner ||
      memory.last_iterations_ > 2 * memory.cold_start_iterations_ + kMaxWorse;
  if (is_new) {
    memory.preconditioner = std::make_unique<Preconditioner>();
    if (!MakePreconditioner(system, memory.preconditioner.get())) {
      memory.preconditioner.reset();
      return false;
    }
  }
  Columns<kNum> columns = sides->middleCols<kNum>(first), solution;
  if (is_started) solution = x->middleCols<kNum>(first);
  const bool is_solved =
      ConjugateGradients<kNum>(system, is_started, &columns, &solution);
  if (is_new)
    memory.cold_start_iterations_ =
        is_started ? kMaxWorse : memory.last_iterations_;
  sides->middleCols<kNum>(first) = columns;
  x->middleCols<kNum>(first) = solution;
  return is_solved;
}

// Solves for several right-hand sides at once, so that each Jacobian is read
// only once.
bool LargeEquations::SolveSystem(const System& system, bool is_started,
                                 Eigen::MatrixXd* sides,
                                 Eigen::MatrixXd* x) const {
  const auto solve = [&](auto num, Eigen::Index first) {
    return SolveColumns<num>(system, is_started, first, sides, x);
  };
  Eigen::Index first = 0;
  bool is_solved = true;
  while (is_solved && first < sides->cols()) {
    const Eigen::Index left = sides->cols() - first;
    if (left >= 8) {
      is_solved = solve(std::integral_constant<int, 8>(), first);
      first += 8;
    } else if (left >= 4) {
      is_solved = solve(std::integral_constant<int, 4>(), first);
      first += 4;
    } else {
      is_solved = solve(std::integral_constant<int, 1>(), first);
      ++first;
    }
  }
  return is_solved;
}

void LargeEquations::AddPoseProduct(int pose, const PoseVector& y,
                                    Eigen::VectorXd* sum) const {
  for (const int v : poses_[pose].views) {
    const ViewJacobian& j = jacobians_[v];
    const ResidualProduct product(static_deformation_.moved(), j);
    for (int i = 0; i < j.count(); ++i)
      product.AddTransposed<1>(j.PoseJacobian(i).transpose() * y, i, sum);
  }
}

PoseVector LargeEquations::ComputePoseProduct(int pose,
                                              const Eigen::VectorXd& x) const {
  PoseVector y = PoseVector::Zero(layout_.per_pose);
  for (const int v : poses_[pose].views) {
    const ViewJacobian& j = jacobians_[v];
    const ResidualProduct product(static_deformation_.moved(), j);
    for (int i = 0; i < j.count(); ++i)
      y.noalias() += j.PoseJacobian(i) * product.Times<1>(x, i);
  }
  return y;
}

Eigen::VectorXd LargeEquations::EliminatePoses(
    const System& system, const Eigen::VectorXd& poses) const {
  const int k = layout_.per_pose;
  return SumOverPoses<1>([&](int p, Eigen::VectorXd* sum) {
    AddPoseProduct(p, system.poses[p].solve(poses.segment(k * p, k)), sum);
  });
}

Eigen::VectorXd LargeEquations::BackSubstitutePoses(
    const System& system, const Eigen::VectorXd& x,
    Eigen::VectorXd poses) const {
  const int k = layout_.per_pose;
  const Eigen::VectorXd moved = static_deformation_.MapToPoints(x);
  ParallelFor(layout_.num_poses, num_threads_, [&](int p) {
    auto pose = poses.segment(k * p, k);
    pose = system.poses[p].solve(pose - ComputePoseProduct(p, moved));
  });
  return poses;
}

bool LargeEquations::Solve(double lambda, AdjustmentStep* step) const {
  System system;
  if (!MakeSystem(lambda, &system)) return false;
  Eigen::VectorXd gradient(layout_.per_pose * layout_.num_poses);
  for (int p = 0; p < layout_.num_poses; ++p)
    gradient.segment(layout_.per_pose * p, layout_.per_pose) =
        poses_[p].gradient;
  Eigen::MatrixXd side = EliminatePoses(system, gradient) - gradient_;
  Eigen::MatrixXd x(layout_.size, 1);
  if (!SolveSystem(system, false, &side, &x)) return false;
  const Eigen::VectorXd poses = BackSubstitutePoses(system, x, -gradient);
  *step = layout_.UnpackStep(x, poses);
  return poses.allFinite();
}

bool LargeEquations::SolveAll(double lambda, bool is_started,
                              const Eigen::MatrixXd& right,
                              Eigen::MatrixXd* solution,
                              Eigen::MatrixXd* rest) const {
  System system;
  if (!MakeSystem(lambda, &system)) return false;
  const Eigen::Index size = layout_.size;
  const Eigen::Index num_poses = right.rows() - size;  // 0 or all
  Eigen::MatrixXd sides = right.topRows(size);
  for (Eigen::Index k = 0; num_poses > 0 && k < right.cols(); ++k)
    sides.col(k) -= EliminatePoses(system, right.col(k).tail(num_poses));
  Eigen::MatrixXd& x = workspace_->last_solution;
  if (!is_started) x.resize(size, right.cols());
  if (!SolveSystem(system, is_started, &sides, &x)) {
    x.resize(0, 0);
    return false;
  }
  solution->resize(right.rows(), right.cols());
  solution->topRows(size) = x;
  for (Eigen::Index k = 0; num_poses > 0 && k < right.cols(); ++k)
    solution->col(k).tail(num_poses) =
        BackSubstitutePoses(system, x.col(k), right.col(k).tail(num_poses));
  rest->setZero(right.rows(), right.cols());
  rest->topRows(size) = sides;
  return true;
}

bool LargeEquations::SolveFor(double lambda, const Eigen::MatrixXd& right,
                              Eigen::MatrixXd* solution) const {
  Eigen::MatrixXd rest;
  const bool is_solved = SolveAll(lambda, false, right, solution, &rest);
  workspace_->last_solution.resize(0, 0);  // no warm start for other sides
  return is_solved;
}

bool LargeEquations::SolveWithResidual(double lambda,
                                       const Eigen::MatrixXd& right,
                                       Eigen::MatrixXd* solution,
                                       Eigen::MatrixXd* rest) const {
  // Warm start: the solution changes little between successive normal
  // equations.
  const Eigen::MatrixXd& last = workspace_->last_solution;
  const bool has_last_solution =
      last.rows() == layout_.size && last.cols() == right.cols();
  return SolveAll(lambda, has_last_solution, right, solution, rest);
}

}  // namespace raygrid
