#include "adjustment/normal_equations.h"

#include <Eigen/LU>

#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

// Which parameters there are: cameras, their poses in the rig, points, poses.
struct Layout {
  int num_cameras = 0, num_points = 0, num_poses = 0;

  Layout(const SmallProblem& problem, bool fix_cameras, bool fix_points)
      : num_cameras(
            fix_cameras ? 0 : static_cast<int>(problem.state.cameras.size())),
        num_points(fix_points ? 0
                              : static_cast<int>(problem.state.points.size())),
        num_poses(static_cast<int>(problem.state.rig_from_pattern.size())) {}

  int Camera(int c) const { return OpenCvModel::kCount * c; }
  int CameraPose(int c) const { return Camera(num_cameras) + 6 * (c - 1); }
  int Point(int i) const {
    return CameraPose(std::max(1, num_cameras)) + 3 * i;
  }
  int Pose(int i) const { return Point(num_points) + 6 * i; }
  int Size() const { return Pose(num_poses); }
};

// H and g of all parameters at once.
struct DenseEquations {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
};

Eigen::MatrixXd DenseJacobian(const LinearizedResidual& r,
                              const Layout& layout) {
  Eigen::MatrixXd row = Eigen::MatrixXd::Zero(2, layout.Size());
  if (layout.num_cameras > 0)
    row.middleCols<OpenCvModel::kCount>(layout.Camera(r.camera)) =
        DenseByParameter(r.projection, OpenCvModel::kCount);
  if (layout.num_cameras > 0 && r.camera > 0)
    row.middleCols<6>(layout.CameraPose(r.camera)) = r.by_camera_pose;
  if (layout.num_points > 0)
    row.middleCols<3>(layout.Point(r.point)) = r.by_point;
  row.middleCols<6>(layout.Pose(r.pose)) = r.by_pose;
  return row;
}

void AddDensePrior(const GaussianPrior& prior, const AdjustmentState& state,
                   const Layout& layout, DenseEquations* dense) {
  constexpr int n = OpenCvModel::kCount;
  for (int c = 0; c < layout.num_cameras; ++c) {
    const CameraPrior& camera = prior.cameras[c];
    const Eigen::MatrixXd k = WeightedPrecision(camera) +
                              camera.orientation_weight * camera.orientation *
                                  camera.orientation.transpose();
    dense->h.block<n, n>(layout.Camera(c), layout.Camera(c)) += k;
    dense->g.segment<n>(layout.Camera(c)) +=
        k * (state.cameras[c]->Parameters() - camera.mean);
  }
  for (int i = 0; i < layout.num_points; ++i) {
    dense->h.diagonal().segment<3>(layout.Point(i)).array() +=
        prior.points_weight;
    dense->g.segment<3>(layout.Point(i)) +=
        prior.points_weight * (state.points[i] - prior.points_mean[i]);
  }
}

DenseEquations BuildDense(const std::vector<View>& views,
                          const AdjustmentState& state,
                          const GaussianPrior& prior, const Layout& layout) {
  DenseEquations dense = {Eigen::MatrixXd::Zero(layout.Size(), layout.Size()),
                          Eigen::VectorXd::Zero(layout.Size())};
  for (const LinearizedResidual& r : LinearizeResiduals(state, views, 1)) {
    const Eigen::MatrixXd row = DenseJacobian(r, layout);
    const double weight = HuberWeight(r.residual.error_px.norm(), 1);
    dense.h += weight * row.transpose() * row;
    dense.g += weight * row.transpose() * r.residual.error_px;
  }
  AddDensePrior(prior, state, layout, &dense);
  return dense;
}

NormalEquations BuildSparse(const std::vector<View>& views,
                            const AdjustmentState& state,
                            const GaussianPrior& prior, bool fix_cameras,
                            bool fix_points, int num_threads = 1) {
  NormalEquations equations(
      NormalEquations::SizesOf(state, fix_cameras, fix_points), num_threads);
  equations.AddResiduals(LinearizeResiduals(state, views, 1), 1);
  equations.AddPrior(prior, state);
  return equations;
}

// In the dense order.
Eigen::VectorXd Stacked(const AdjustmentStep& step, const Layout& layout) {
  Eigen::VectorXd stacked(layout.Size());
  for (int c = 0; c < layout.num_cameras; ++c)
    stacked.segment<OpenCvModel::kCount>(layout.Camera(c)) = step.cameras[c];
  for (int c = 1; c < layout.num_cameras; ++c)
    stacked.segment<6>(layout.CameraPose(c)) = step.camera_poses[c - 1];
  stacked.segment(layout.Point(0), 3 * layout.num_points) = step.points;
  for (int i = 0; i < layout.num_poses; ++i)
    stacked.segment<6>(layout.Pose(i)) = step.poses[i];
  return stacked;
}

// Every parameter's step compared in units of its own uncertainty.
void ExpectDenseSolution(const SmallProblemSizes& sizes, bool fix_camera,
                         bool fix_points) {
  const SmallProblem problem = MakeSmallProblem(sizes);
  const AdjustmentState state = Disturbed(problem.state, !fix_points);
  GaussianPrior prior = PriorOf(problem);
  TestRandom random(4);
  prior.cameras[0].orientation.resize(OpenCvModel::kCount, 3);
  for (int k = 0; k < prior.cameras[0].orientation.size(); ++k)
    prior.cameras[0].orientation.data()[k] = random.Normal();
  prior.cameras[0].orientation_weight = 2;
  const Layout layout(problem, fix_camera, fix_points);
  for (const double lambda : {1e-4, 1.0}) {
    DenseEquations dense = BuildDense(problem.views, state, prior, layout);
    dense.h.diagonal() *= 1 + lambda;
    const Eigen::VectorXd expected = -dense.h.llt().solve(dense.g);
    AdjustmentStep step;
    ASSERT_TRUE(BuildSparse(problem.views, state, prior, fix_camera, fix_points)
                    .Solve(lambda, &step));
    ASSERT_EQ(step.points.size(), 3 * layout.num_points);
    const Eigen::VectorXd scale = dense.h.inverse().diagonal().cwiseSqrt();
    EXPECT_LT((Stacked(step, layout) - expected)
                  .cwiseQuotient(scale)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-5 * expected.cwiseQuotient(scale).cwiseAbs().maxCoeff());
  }
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

TEST(NormalEquations, SolutionDoesNotDependOnTheNumberOfThreads) {
  const SmallProblem problem = MakeSmallProblem({40, 60, 0.4});
  const GaussianPrior prior = PriorOf(problem);
  const AdjustmentState state = Disturbed(problem.state, true);
  AdjustmentStep one, three;
  ASSERT_TRUE(BuildSparse(problem.views, state, prior, false, false, 1)
                  .Solve(1e-3, &one));
  ASSERT_TRUE(BuildSparse(problem.views, state, prior, false, false, 3)
                  .Solve(1e-3, &three));
  EXPECT_EQ(one.cameras, three.cameras);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.poses, three.poses);
}

TEST(NormalEquations, ResidualsThatAreNotValidDoNotCount) {
  const SmallProblem problem = MakeSmallProblem({5, 30, 0.4});
  const GaussianPrior prior = PriorOf(problem);
  std::vector<LinearizedResidual> all =
      LinearizeResiduals(problem.state, problem.views, 1);
  std::vector<LinearizedResidual> some;
  for (size_t i = 0; i < all.size(); ++i) {
    if (i % 3 == 0) all[i].residual.valid = false;
    if (i % 3 != 0) some.push_back(all[i]);
  }
  AdjustmentStep steps[2];
  int k = 0;
  for (const auto& residuals : {all, some}) {
    NormalEquations equations(
        NormalEquations::SizesOf(problem.state, false, false), 1);
    equations.AddResiduals(residuals, 1);
    equations.AddPrior(prior, problem.state);
    ASSERT_TRUE(equations.Solve(1e-3, &steps[k++]));
  }
  EXPECT_EQ(steps[0].cameras, steps[1].cameras);
}

// Expects the traces of K times the covariance that the evidence approximation
// needs, from samples, to be the exact ones.
void ExpectTraces(int num_views, int num_points) {
  const SmallProblem problem = MakeSmallProblem({num_views, num_points, 0.3});
  const GaussianPrior prior = PriorOf(problem);
  const Layout layout(problem, false, false);
  const Eigen::MatrixXd covariance =
      BuildDense(problem.views, problem.state, prior, layout).h.inverse();
  CovarianceSamples samples;
  constexpr int kNumSamples = 3000;
  ASSERT_TRUE(BuildSparse(problem.views, problem.state, prior, false, false)
                  .SampleCovariance(kNumSamples, &samples));
  constexpr int n = OpenCvModel::kCount;
  const double camera_trace =
      (prior.cameras[0].groups[0].precision * covariance.topLeftCorner(n, n))
          .trace();
  const double points_trace =
      covariance.diagonal().segment(n, 3 * num_points).sum();
  EXPECT_NEAR(samples.cameras[0]
                      .cwiseProduct(prior.cameras[0].groups[0].precision *
                                    samples.cameras[0])
                      .sum() /
                  kNumSamples,
              camera_trace, 0.1 * camera_trace);
  EXPECT_NEAR(samples.points.squaredNorm() / kNumSamples, points_trace,
              0.1 * points_trace);
}

TEST(NormalEquations, SamplesScatterAsTheParametersWithPointsEliminated) {
  ExpectTraces(4, 30);
}

TEST(NormalEquations, SamplesScatterAsTheParametersWithPosesEliminated) {
  ExpectTraces(12, 20);
}

}  // namespace
}  // namespace raygrid
