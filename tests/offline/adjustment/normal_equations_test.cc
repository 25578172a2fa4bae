#include "adjustment/normal_equations.h"

#include <Eigen/LU>
#include <optional>

#include "adjustment/dense_equations.h"
#include "adjustment/large_equations.h"
#include "adjustment/precision_root.h"
#include "adjustment/smoothness_prior.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

// Which parameters there are: cameras, their poses in the rig, places of
// boards, their shapes, points, poses.
struct Layout {
  int num_cameras = 0, num_places = 0, num_shapes = 0, num_points = 0,
      num_poses = 0, per_pose = 6;

  Layout(const SmallProblem& problem, bool fix_cameras, bool fix_points,
         const AdjustmentState& state = {})
      : num_cameras(
            fix_cameras ? 0 : static_cast<int>(problem.state.cameras.size())),
        num_places(
            fix_cameras && fix_points
                ? 0
                : static_cast<int>(problem.state.target_from_board.size())),
        num_shapes(state.HasStaticDeformation() && !(fix_cameras && fix_points)
                       ? state.modes.count() * state.modes.num_boards()
                       : 0),
        num_points(fix_points ? 0
                              : static_cast<int>(problem.state.points.size())),
        num_poses(static_cast<int>(problem.state.rig_from_pattern.size())),
        per_pose(6 +
                 (state.HasPerViewDeformation() ? state.modes.count() : 0)) {}

  int Camera(int c) const { return OpenCvModel::kCount * c; }
  int CameraPose(int c) const { return Camera(num_cameras) + 6 * (c - 1); }
  int Place(int i) const {
    return CameraPose(std::max(1, num_cameras)) + 6 * i;
  }
  int Shape(int i) const { return Place(num_places) + i; }
  int Point(int i) const { return Shape(num_shapes) + 3 * i; }
  int Pose(int i) const { return Point(num_points) + per_pose * i; }
  int Size() const { return Pose(num_poses); }
};

// H and g of all parameters at once.
struct WholeSystem {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
};

Eigen::MatrixXd DenseJacobian(const LinearizedResidual& r,
                              const AdjustmentState& state,
                              const Layout& layout) {
  Eigen::MatrixXd row = Eigen::MatrixXd::Zero(2, layout.Size());
  if (layout.num_cameras > 0)
    row.middleCols<OpenCvModel::kCount>(layout.Camera(r.camera)) =
        DenseByParameter(r.projection, OpenCvModel::kCount);
  if (layout.num_cameras > 0 && r.camera > 0)
    row.middleCols<6>(layout.CameraPose(r.camera)) = r.J_camera_pose;
  if (layout.num_places > 0 && r.place >= 0)
    row.middleCols<6>(layout.Place(r.place)) = r.J_board_pose;
  if (layout.num_points > 0)
    row.middleCols<3>(layout.Point(r.point)) = r.J_point;
  row.middleCols<6>(layout.Pose(r.pose)) = r.J_pose;
  row.middleCols(layout.Pose(r.pose) + 6, r.J_deformation.cols()) =
      r.J_deformation;
  if (layout.num_shapes > 0) {
    const int count = state.modes.count();
    row.middleCols(layout.Shape(count * state.modes.boards[r.point]), count) =
        r.J_point * state.modes.by_point[r.point];
  }
  return row;
}

void AddDensePrior(const GaussianPrior& prior, const AdjustmentState& state,
                   const Layout& layout, WholeSystem* dense) {
  constexpr int n = OpenCvModel::kCount;
  for (int c = 0; c < layout.num_cameras; ++c) {
    const CameraPrior& camera = prior.cameras[c];
    const Eigen::MatrixXd k =
        WeightedPrecision(camera) + camera.orientation_precision *
                                        camera.orientation *
                                        camera.orientation.transpose();
    dense->h.block<n, n>(layout.Camera(c), layout.Camera(c)) += k;
    dense->g.segment<n>(layout.Camera(c)) +=
        k * (state.cameras[c]->Parameters() - camera.mean);
  }
  for (int i = 0; i < layout.num_points; ++i) {
    dense->h.diagonal().segment<3>(layout.Point(i)).array() +=
        prior.points_precision;
    dense->g.segment<3>(layout.Point(i)) +=
        prior.points_precision * (state.points[i] - prior.points_mean[i]);
  }
  const bool has_per_view_deformation =
      state.HasPerViewDeformation() ||
      (state.HasStaticDeformation() && layout.num_shapes > 0);
  for (int i = 0;
       has_per_view_deformation && i < static_cast<int>(state.flex.size()); ++i)
    for (int mode = 0; mode < state.modes.count(); ++mode) {
      const int row = state.HasPerViewDeformation()
                          ? layout.Pose(i) + 6 + mode
                          : layout.Shape(state.modes.count() * i + mode);
      const double weight =
          prior.DeformationPrecision(state.modes.orders[mode]);
      dense->h(row, row) += weight;
      dense->g(row) += weight * state.flex[i][mode];
    }
}

WholeSystem BuildDense(const std::vector<View>& views,
                       const AdjustmentState& state, const GaussianPrior& prior,
                       const Layout& layout) {
  WholeSystem dense = {Eigen::MatrixXd::Zero(layout.Size(), layout.Size()),
                       Eigen::VectorXd::Zero(layout.Size())};
  for (const View& view : views) {
    for (const LinearizedResidual& r : LinearizeView(state, view)) {
      const Eigen::MatrixXd row = DenseJacobian(r, state, layout);
      const double weight = HuberWeight(r.residual.error_px.norm(), 1);
      dense.h += weight * row.transpose() * row;
      dense.g += weight * row.transpose() * r.residual.error_px;
    }
  }
  AddDensePrior(prior, state, layout, &dense);
  return dense;
}

enum class Method { kDense, kLarge };

std::unique_ptr<NormalEquations> BuildFrom(
    const std::vector<ViewJacobian>& jacobians, const AdjustmentState& state,
    const GaussianPrior& prior, const FixedParameters& fixed, Method method,
    int num_threads) {
  constexpr double kTolerance = 1e-10;
  const ParameterLayout layout(state, fixed);
  const PriorEquations prior_equations(prior, state, layout);
  if (method == Method::kDense)
    return std::make_unique<DenseEquations>(layout, jacobians, state.modes,
                                            prior_equations, num_threads);
  return std::make_unique<LargeEquations>(
      layout, jacobians, prior_equations, state, kTolerance, num_threads,
      std::make_shared<LargeEquations::Workspace>());
}

std::unique_ptr<NormalEquations> BuildEquations(const std::vector<View>& views,
                                                const AdjustmentState& state,
                                                const GaussianPrior& prior,
                                                const FixedParameters& fixed,
                                                Method method = Method::kDense,
                                                int num_threads = 1) {
  return BuildFrom(WeightedJacobians(state, views, 1, 1), state, prior, fixed,
                   method, num_threads);
}

// In the dense order.
Eigen::VectorXd Stacked(const AdjustmentStep& step, const Layout& layout) {
  Eigen::VectorXd stacked(layout.Size());
  for (int c = 0; c < layout.num_cameras; ++c)
    stacked.segment<OpenCvModel::kCount>(layout.Camera(c)) = step.cameras[c];
  for (int c = 1; c < layout.num_cameras; ++c)
    stacked.segment<6>(layout.CameraPose(c)) = step.camera_poses[c - 1];
  for (int i = 0; i < layout.num_places; ++i)
    stacked.segment<6>(layout.Place(i)) = step.places[i];
  stacked.segment(layout.Point(0), 3 * layout.num_points) = step.points;
  for (int i = 0; i < layout.num_poses; ++i)
    stacked.segment<6>(layout.Pose(i)) = step.poses[i];
  for (int i = 0; i < static_cast<int>(step.flex.size()); ++i) {
    const auto count = static_cast<int>(step.flex[i].size());
    stacked.segment(
        layout.num_shapes > 0 ? layout.Shape(count * i) : layout.Pose(i) + 6,
        count) = step.flex[i];
  }
  return stacked;
}

// Each board bends at random, by all modes but those of one order.
void Bend(DeformationScope scope, AdjustmentState* state,
          GaussianPrior* prior) {
  std::vector<Eigen::Vector3d> flat = state->points;
  for (Eigen::Vector3d& point : flat) point.z() = 0;
  state->SetModes(
      MakeDeformationModes({{0, flat}}, static_cast<int>(flat.size())), scope);
  ASSERT_EQ(state->modes.count(), DeformationModes::kMaxCount);
  state->modes.Remove(DeformationOrder::kThird, &state->flex);
  TestRandom random(9);
  for (DeformationModes::Coefficients& flex : state->flex)
    for (int mode = 0; mode < state->modes.count(); ++mode)
      flex[mode] = 1e-3 * random.Normal();
  prior->deformation_precisions = {1e5, 2e5, 3e5};
}

// Every parameter's step compared in units of its own uncertainty.
void ExpectDenseSolution(const SmallProblem& problem, bool fix_camera,
                         bool fix_points, Method method = Method::kDense,
                         std::optional<DeformationScope> bends = {}) {
  AdjustmentState state = Disturbed(problem.state, !fix_points);
  GaussianPrior prior = PriorOf(problem);
  if (bends) Bend(*bends, &state, &prior);
  TestRandom random(4);
  prior.cameras[0].orientation.resize(OpenCvModel::kCount, 3);
  for (int k = 0; k < prior.cameras[0].orientation.size(); ++k)
    prior.cameras[0].orientation.data()[k] = random.Normal();
  prior.cameras[0].orientation_precision = 2;
  const Layout layout(problem, fix_camera, fix_points, state);
  for (const double lambda : {1e-4, 1.0}) {
    WholeSystem dense = BuildDense(problem.views, state, prior, layout);
    dense.h.diagonal() *= 1 + lambda;
    const Eigen::VectorXd expected = -dense.h.llt().solve(dense.g);
    AdjustmentStep step;
    ASSERT_TRUE(BuildEquations(problem.views, state, prior,
                               {fix_camera, fix_points}, method)
                    ->Solve(lambda, &step));
    ASSERT_EQ(step.points.size(), 3 * layout.num_points);
    const Eigen::VectorXd scale = dense.h.inverse().diagonal().cwiseSqrt();
    EXPECT_LT((Stacked(step, layout) - expected)
                  .cwiseQuotient(scale)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-5 * expected.cwiseQuotient(scale).cwiseAbs().maxCoeff());
  }
}

void ExpectDenseSolution(const SmallProblemSizes& sizes, bool fix_camera,
                         bool fix_points, Method method = Method::kDense,
                         std::optional<DeformationScope> bends = {}) {
  ExpectDenseSolution(MakeSmallProblem(sizes), fix_camera, fix_points, method,
                      bends);
}

TEST(NormalEquations, EliminatingPointsSolvesTheWholeSystem) {
  ExpectDenseSolution({4, 30, 0.4}, false, false);  // 90 > 24
}

TEST(NormalEquations, EliminatingPosesSolvesTheWholeSystem) {
  ExpectDenseSolution({12, 20, 0.4}, false, false);  // 60 < 72
}

TEST(NormalEquations, FixedPointsAreNotInTheSystem) {
  ExpectDenseSolution({6, 30, 0.4}, false, true);
}

TEST(NormalEquations, FixedCameraIsNotInTheSystem) {
  ExpectDenseSolution({4, 30, 0.4}, true, false);
  ExpectDenseSolution({12, 20, 0.4}, true, false);
}

TEST(NormalEquations, CamerasOfARigShareTheirPoses) {
  ExpectDenseSolution({4, 30, 0.4, 3}, false, false);
  ExpectDenseSolution({12, 20, 0.4, 2}, false, false);
  ExpectDenseSolution({6, 30, 0.4, 2}, false, true);
  ExpectDenseSolution({6, 30, 0.4, 2}, true, false);
}

TEST(LargeEquations, SolveTheWholeSystem) {
  ExpectDenseSolution({4, 30, 0.4}, false, false, Method::kLarge);
  ExpectDenseSolution({12, 20, 0.4}, false, false, Method::kLarge);
  ExpectDenseSolution({6, 30, 0.4}, false, true, Method::kLarge);
  ExpectDenseSolution({12, 20, 0.4, 2}, false, false, Method::kLarge);
}

TEST(NormalEquations, BoardsOfABodyShareItsPoses) {
  const auto expect = [](const SmallProblemSizes& sizes, bool fix_cameras,
                         bool fix_points, Method method) {
    ExpectDenseSolution(WithTwoBoardsOnABody(MakeSmallProblem(sizes)),
                        fix_cameras, fix_points, method);
  };
  expect({4, 30, 0.4}, false, false, Method::kDense);
  expect({12, 20, 0.4}, false, false, Method::kDense);
  expect({6, 30, 0.4, 2}, false, true, Method::kDense);
  expect({6, 30, 0.4, 2}, true, false, Method::kDense);
  expect({6, 30, 0.4}, true, true, Method::kDense);
  expect({4, 30, 0.4}, false, false, Method::kLarge);
  expect({12, 20, 0.4, 2}, false, true, Method::kLarge);
}

TEST(NormalEquations, BendsAreSolvedForWithTheirPoses) {
  ExpectDenseSolution({4, 60, 0.4}, false, false, Method::kDense,
                      DeformationScope::kPose);
  ExpectDenseSolution({12, 20, 0.4}, false, false, Method::kDense,
                      DeformationScope::kPose);
  ExpectDenseSolution({6, 30, 0.4, 2}, false, true, Method::kDense,
                      DeformationScope::kPose);
  ExpectDenseSolution({6, 30, 0.4}, true, true, Method::kDense,
                      DeformationScope::kPose);
  ExpectDenseSolution({4, 60, 0.4}, false, false, Method::kLarge,
                      DeformationScope::kPose);
  ExpectDenseSolution({12, 20, 0.4, 2}, false, false, Method::kLarge,
                      DeformationScope::kPose);
}

TEST(NormalEquations, ShapesAreSolvedForBesideTheCameras) {
  const DeformationScope of = DeformationScope::kBoard;
  ExpectDenseSolution({4, 60, 0.4}, false, false, Method::kDense, of);
  ExpectDenseSolution({12, 20, 0.4}, false, false, Method::kDense, of);
  ExpectDenseSolution({6, 30, 0.4, 2}, false, true, Method::kDense, of);
  ExpectDenseSolution({6, 30, 0.4}, true, true, Method::kDense, of);
  ExpectDenseSolution({4, 60, 0.4}, false, false, Method::kLarge, of);
  ExpectDenseSolution({12, 20, 0.4, 2}, false, true, Method::kLarge, of);
  ExpectDenseSolution(WithTwoBoardsOnABody(MakeSmallProblem({12, 20, 0.4})),
                      false, false, Method::kDense, of);
}

// A square of all coordinates would take 115 GB.
TEST(NormalEquations, FixedPointsTakeNoMemoryBesideShapes) {
  SmallProblem problem = MakeSmallProblem({6, 30, 0.4});
  problem.state.points.resize(40000, Eigen::Vector3d(0.1, 0.05, 0));
  GaussianPrior prior = PriorOf(problem);
  Bend(DeformationScope::kBoard, &problem.state, &prior);
  AdjustmentStep step;
  EXPECT_TRUE(BuildEquations(problem.views, problem.state, prior, {false, true})
                  ->Solve(1e-4, &step));
}

TEST(NormalEquations, SolutionDoesNotDependOnTheNumberOfThreads) {
  const SmallProblem problem = MakeSmallProblem({40, 60, 0.4});
  const GaussianPrior prior = PriorOf(problem);
  const AdjustmentState state = Disturbed(problem.state, true);
  for (const Method method : {Method::kDense, Method::kLarge}) {
    AdjustmentStep one, three;
    ASSERT_TRUE(BuildEquations(problem.views, state, prior, {}, method, 1)
                    ->Solve(1e-3, &one));
    ASSERT_TRUE(BuildEquations(problem.views, state, prior, {}, method, 3)
                    ->Solve(1e-3, &three));
    EXPECT_EQ(one.cameras, three.cameras);
    EXPECT_EQ(one.points, three.points);
    EXPECT_EQ(one.poses, three.poses);
  }
}

TEST(NormalEquations, ResidualsThatAreNotValidDoNotCount) {
  const SmallProblem problem = MakeSmallProblem({5, 30, 0.4});
  const GaussianPrior prior = PriorOf(problem);
  std::vector<ViewJacobian> all, some;
  for (const View& view : problem.views) {
    std::vector<LinearizedResidual> marked = LinearizeView(problem.state, view);
    std::vector<LinearizedResidual> kept;
    for (size_t i = 0; i < marked.size(); ++i) {
      if (i % 3 == 0) marked[i].residual.valid = false;
      if (i % 3 != 0) kept.push_back(marked[i]);
    }
    all.push_back(WeightedJacobian(marked, 1));
    some.push_back(WeightedJacobian(kept, 1));
  }
  for (const Method method : {Method::kDense, Method::kLarge}) {
    AdjustmentStep steps[2];
    ASSERT_TRUE(BuildFrom(all, problem.state, prior, {}, method, 1)
                    ->Solve(1e-3, &steps[0]));
    ASSERT_TRUE(BuildFrom(some, problem.state, prior, {}, method, 1)
                    ->Solve(1e-3, &steps[1]));
    EXPECT_EQ(steps[0].cameras, steps[1].cameras);
  }
}

// With bends the poses' part of the inverse, too.
void ExpectInverse(const SmallProblemSizes& sizes, Method method,
                   std::optional<DeformationScope> bends = {}) {
  SmallProblem problem = MakeSmallProblem(sizes);
  GaussianPrior prior = PriorOf(problem);
  if (bends) Bend(*bends, &problem.state, &prior);
  const Layout layout(problem, false, false, problem.state);
  WholeSystem dense = BuildDense(problem.views, problem.state, prior, layout);
  dense.h.diagonal() *= 1 + 1e-6;
  const Eigen::MatrixXd inverse = dense.h.inverse();
  const int size = bends ? layout.Size() : layout.Pose(0);
  Eigen::MatrixXd solution;
  ASSERT_TRUE(
      BuildEquations(problem.views, problem.state, prior, {}, method)
          ->SolveFor(1e-6, Eigen::MatrixXd::Identity(size, size), &solution));
  const Eigen::VectorXd scale = inverse.diagonal().head(size).cwiseSqrt();
  EXPECT_LT((solution - inverse.topLeftCorner(size, size))
                .cwiseQuotient(scale * scale.transpose())
                .cwiseAbs()
                .maxCoeff(),
            1e-5);
}

TEST(NormalEquations, SolveForGivesColumnsOfTheInverse) {
  for (const Method method : {Method::kDense, Method::kLarge}) {
    ExpectInverse({4, 30, 0.3}, method);   // points eliminated
    ExpectInverse({12, 20, 0.3}, method);  // poses eliminated
    ExpectInverse({4, 60, 0.3}, method, DeformationScope::kPose);
    ExpectInverse({4, 60, 0.3}, method, DeformationScope::kBoard);
    ExpectInverse({12, 20, 0.3}, method, DeformationScope::kPose);
  }
}

// A problem with a grid of several levels and a smoothness prior, and right
// sides as those of the prior's strength.
struct SmoothProblem {
  SmallProblem problem;
  GaussianPrior prior;
  std::vector<ViewJacobian> jacobians;
  Eigen::MatrixXd sides;

  LargeEquations Equations(
      double tolerance,
      const std::shared_ptr<LargeEquations::Workspace>& memory) const {
    const ParameterLayout layout(problem.state, {});
    return {
        layout,        jacobians, PriorEquations(prior, problem.state, layout),
        problem.state, tolerance, 1,
        memory};
  }
};

SmoothProblem MakeSmoothProblem(int num_sides, bool has_lines = false,
                                double knot_spacing_px = 30) {
  SmoothProblem smooth = {MakeSmallProblem({30, 60, 0.3}), {}, {}, {}};
  AdjustmentState& state = smooth.problem.state;
  const CentralGeneric grid = FittedGrid(state.camera(), knot_spacing_px);
  if (has_lines) {
    state.SetCamera(NonCentralGeneric(grid));
    smooth.prior.cameras = {MakeNonCentralPrior(grid, {}, 0.7)};
  } else {
    state.SetCamera(grid);
    smooth.prior.cameras = {MakeSmoothnessPrior(grid, {})};
  }
  for (PriorGroup& group : smooth.prior.cameras[0].groups) group.weight = 0.1;
  smooth.prior.points_mean = state.points;
  smooth.prior.points_precision = 1e4;
  smooth.jacobians = WeightedJacobians(state, smooth.problem.views, 1, 1);
  const ParameterLayout layout(state, {});
  std::mt19937 random_bits(1);
  const PrecisionRoot root(smooth.prior.cameras[0].groups[0].precision);
  smooth.sides = Eigen::MatrixXd::Zero(layout.size, num_sides);
  for (int k = 0; k < num_sides; ++k)
    smooth.sides.col(k).head(layout.first_point) =
        root.Times(RandomSigns(root.size(), &random_bits), layout.first_point);
  return smooth;
}

void ExpectDenseStep(const SmoothProblem& smooth) {
  const auto& [problem, prior, jacobians, sides] = smooth;
  AdjustmentStep dense, large;
  ASSERT_TRUE(
      BuildEquations(problem.views, problem.state, prior, {}, Method::kDense)
          ->Solve(1e-6, &dense));
  ASSERT_TRUE(
      BuildEquations(problem.views, problem.state, prior, {}, Method::kLarge)
          ->Solve(1e-6, &large));
  EXPECT_LT(RelativeDifference(large.cameras[0], dense.cameras[0]), 1e-5);
  EXPECT_LT(RelativeDifference(large.points, dense.points), 1e-5);
  for (size_t i = 0; i < dense.poses.size(); ++i)
    EXPECT_LT(RelativeDifference(large.poses[i], dense.poses[i]), 1e-4);
}

TEST(LargeEquations, TakeTheDenseStepOfAGrid) {
  ExpectDenseStep(MakeSmoothProblem(0));
}

TEST(LargeEquations, TakeTheDenseStepOfAGridOfLines) {
  ExpectDenseStep(MakeSmoothProblem(0, true, 50));
}

TEST(LargeEquations, SolveForEachSideAsIfItWasAlone) {
  constexpr double kLambda = 1e-6, kTolerance = 1e-8;
  SmoothProblem smooth = MakeSmoothProblem(13);  // taken as 8, 4 and 1
  smooth.sides.col(2) *= 1e6;
  smooth.sides.col(5).setZero();
  const auto memory = std::make_shared<LargeEquations::Workspace>();
  const LargeEquations equations = smooth.Equations(kTolerance, memory);
  Eigen::MatrixXd together, alone;
  ASSERT_TRUE(equations.SolveFor(kLambda, smooth.sides, &together));
  for (Eigen::Index k = 0; k < smooth.sides.cols(); ++k) {
    ASSERT_TRUE(equations.SolveFor(kLambda, smooth.sides.col(k), &alone));
    EXPECT_LE((together.col(k) - alone).norm(), 1e-6 * alone.norm()) << k;
  }
}

// A prior whose strength settles, as it is learned: equations of a loose
// tolerance start from the last one's solution, and are soon done.
TEST(LargeEquations, TellWhatTheirSolutionsLeave) {
  constexpr double kLambda = 1e-6, kTolerance = 0.01;
  constexpr int kSides = 8;
  SmoothProblem smooth = MakeSmoothProblem(kSides);
  const auto memory = std::make_shared<LargeEquations::Workspace>();
  Eigen::MatrixXd right, solution, rest, exact;
  for (const double weight : {1.0, 1.3, 1.25, 1.26}) {
    smooth.prior.cameras[0].groups[0].weight = weight;
    right = std::sqrt(weight) * smooth.sides;
    ASSERT_TRUE(smooth.Equations(kTolerance, memory)
                    .SolveWithResidual(kLambda, right, &solution, &rest));
  }
  const ParameterLayout layout(smooth.problem.state, {});
  const DenseEquations dense(
      layout, smooth.jacobians, smooth.problem.state.modes,
      PriorEquations(smooth.prior, smooth.problem.state, layout), 1);
  ASSERT_TRUE(dense.SolveFor(kLambda, right, &exact));
  const auto products = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    return Eigen::RowVectorXd(a.cwiseProduct(b).colwise().sum());
  };
  const Eigen::RowVectorXd error = products(right, solution - exact);
  const Eigen::RowVectorXd made_good = error + products(rest, solution);
  EXPECT_LT(made_good.norm(), 0.3 * error.norm());
  // Nothing is left of direct solutions.
  ASSERT_TRUE(dense.SolveWithResidual(kLambda, right, &solution, &rest));
  EXPECT_EQ(solution, exact);
  EXPECT_EQ(rest, Eigen::MatrixXd::Zero(layout.size, kSides));
}

// A grid too large to be factored at once.
TEST(DenseIsFaster, WhereIterationsTakeMoreOperations) {
  SmallProblem problem = MakeSmallProblem({3, 4, 0});
  problem.state.SetCamera(FittedGrid(problem.state.camera(), 30));
  const ParameterLayout layout(problem.state, {false, true});
  const double size = NumDenseUnknowns(layout);
  ASSERT_GT(size, 600);
  EXPECT_FALSE(DenseIsFaster(layout, 0));
  EXPECT_FALSE(DenseIsFaster(layout, size * size));
  EXPECT_TRUE(DenseIsFaster(layout, size * size * size));
}

}  // namespace
}  // namespace raygrid
