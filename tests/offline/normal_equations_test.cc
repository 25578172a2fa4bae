#include "adjustment/normal_equations.h"

#include <Eigen/LU>

#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

// Which parameters there are, in the order camera, points, poses.
struct Layout {
  int num_camera = 0, num_points = 0, num_views = 0;

  Layout(const SmallProblem& problem, bool fix_camera, bool fix_points)
      : num_camera(fix_camera ? 0 : OpenCvModel::kCount),
        num_points(fix_points ? 0
                              : static_cast<int>(problem.state.points.size())),
        num_views(static_cast<int>(problem.views.size())) {}

  int Point(int i) const { return num_camera + 3 * i; }
  int View(int i) const { return Point(num_points) + 6 * i; }
  int Size() const { return View(num_views); }
};

// H and g of all parameters at once.
struct DenseEquations {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
};

Eigen::MatrixXd DenseJacobian(const LinearizedResidual& r,
                              const Layout& layout) {
  Eigen::MatrixXd row = Eigen::MatrixXd::Zero(2, layout.Size());
  if (layout.num_camera > 0)
    row.leftCols(layout.num_camera) =
        DenseByParameter(r.projection, layout.num_camera);
  if (layout.num_points > 0)
    row.middleCols<3>(layout.Point(r.point)) = r.by_point;
  row.middleCols<6>(layout.View(r.view)) = r.by_pose;
  return row;
}

void AddDensePrior(const GaussianPrior& prior, const AdjustmentState& state,
                   const Layout& layout, DenseEquations* dense) {
  const int n = layout.num_camera;
  if (n > 0) {
    const Eigen::MatrixXd k =
        prior.camera_weight * Eigen::MatrixXd(prior.camera_precision) +
        prior.orientation_weight * prior.orientation *
            prior.orientation.transpose();
    dense->h.topLeftCorner(n, n) += k;
    dense->g.head(n) += k * (state.camera->Parameters() - prior.camera_mean);
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
                            const GaussianPrior& prior, bool fix_camera,
                            bool fix_points, int num_threads = 1) {
  NormalEquations equations(
      {OpenCvModel::kCount, static_cast<int>(state.points.size()),
       static_cast<int>(views.size()), fix_camera, fix_points},
      num_threads);
  equations.AddResiduals(LinearizeResiduals(state, views, 1), 1);
  equations.AddPrior(prior, state);
  return equations;
}

// In the dense order.
Eigen::VectorXd Stacked(const AdjustmentStep& step, const Layout& layout) {
  Eigen::VectorXd stacked(layout.Size());
  stacked.head(layout.num_camera) = step.camera;
  stacked.segment(layout.Point(0), 3 * layout.num_points) = step.points;
  for (int i = 0; i < layout.num_views; ++i)
    stacked.segment<6>(layout.View(i)) = step.poses[i];
  return stacked;
}

// Every parameter's step compared in units of its own uncertainty.
void ExpectDenseSolution(int num_views, int num_points, bool fix_camera,
                         bool fix_points) {
  const SmallProblem problem = MakeSmallProblem({num_views, num_points, 0.4});
  const AdjustmentState state = Disturbed(problem.state, !fix_points);
  GaussianPrior prior = PriorOf(problem);
  TestRandom random(4);
  prior.orientation.resize(OpenCvModel::kCount, 3);
  for (int k = 0; k < prior.orientation.size(); ++k)
    prior.orientation.data()[k] = random.Normal();
  prior.orientation_weight = 2;
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
  ExpectDenseSolution(4, 30, false, false);  // 90 > 24
}

TEST(NormalEquations, EliminatingPosesSolvesTheWholeSystem) {
  ExpectDenseSolution(12, 20, false, false);  // 60 < 72
}

TEST(NormalEquations, FixedPointsAreNotInTheSystem) {
  ExpectDenseSolution(6, 30, false, true);
}

TEST(NormalEquations, FixedCameraIsNotInTheSystem) {
  ExpectDenseSolution(4, 30, true, false);
  ExpectDenseSolution(12, 20, true, false);
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
  EXPECT_EQ(one.camera, three.camera);
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
    NormalEquations equations({OpenCvModel::kCount, 30, 5, false, false}, 1);
    equations.AddResiduals(residuals, 1);
    equations.AddPrior(prior, problem.state);
    ASSERT_TRUE(equations.Solve(1e-3, &steps[k++]));
  }
  EXPECT_EQ(steps[0].camera, steps[1].camera);
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
  const int n = layout.num_camera;
  const double camera_trace =
      (prior.camera_precision * covariance.topLeftCorner(n, n)).trace();
  const double points_trace =
      covariance.diagonal().segment(n, 3 * num_points).sum();
  EXPECT_NEAR(
      samples.camera.cwiseProduct(prior.camera_precision * samples.camera)
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
