// Ceres is the oracle: it solves the same problem, stated independently.

#include "adjustment/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <ceres/rotation.h>

#include "adjustment/smoothness_prior.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

// The rational model as OpenCV documents it; c as in OpenCvModel.
struct ReprojectionCost {
  Eigen::Vector2d pixel;

  template <typename T>
  bool operator()(const T* c, const T* pose, const T* point, T* error) const {
    T p[3];
    ceres::AngleAxisRotatePoint(pose, point, p);
    const T x = (p[0] + pose[3]) / (p[2] + pose[5]);
    const T y = (p[1] + pose[4]) / (p[2] + pose[5]);
    const T r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const T radial = (T(1) + c[4] * r2 + c[5] * r4 + c[6] * r6) /
                     (T(1) + c[7] * r2 + c[8] * r4 + c[9] * r6);
    const T p1 = c[10], p2 = c[11];
    const T xd = x * radial + T(2) * p1 * x * y + p2 * (r2 + T(2) * x * x);
    const T yd = y * radial + p1 * (r2 + T(2) * y * y) + T(2) * p2 * x * y;
    error[0] = c[0] * xd + c[2] - pixel.x();
    error[1] = c[1] * yd + c[3] - pixel.y();
    return true;
  }
};

// weight * (x - mean), coordinate by coordinate.
template <int N>
struct PriorCost {
  Eigen::Matrix<double, N, 1> mean, weight;

  template <typename T>
  bool operator()(const T* x, T* error) const {
    for (int k = 0; k < N; ++k) error[k] = weight[k] * (x[k] - mean[k]);
    return true;
  }
};

template <int N>
ceres::CostFunction* NewPriorCost(const Eigen::Matrix<double, N, 1>& mean,
                                  const Eigen::Matrix<double, N, 1>& weight) {
  return new ceres::AutoDiffCostFunction<PriorCost<N>, N, N>(
      new PriorCost<N>{mean, weight});
}

struct Solution {
  double cost = 0;
  Eigen::VectorXd camera;
  std::vector<Eigen::Vector3d> points;
  std::vector<Pose> poses;
};

using PoseParameters = Eigen::Matrix<double, 6, 1>;

std::vector<PoseParameters> ToParameters(const std::vector<Pose>& poses) {
  std::vector<PoseParameters> parameters;
  for (const Pose& pose : poses) {
    const Eigen::AngleAxisd rotation(pose.rotation);
    parameters.emplace_back();
    parameters.back() << rotation.angle() * rotation.axis(), pose.translation;
  }
  return parameters;
}

void AddPriorBlocks(const GaussianPrior& prior, double* camera,
                    std::vector<Eigen::Vector3d>* points,
                    ceres::Problem* problem) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> precision(
      WeightedPrecision(prior.cameras[0]));
  const Eigen::MatrixXd root =
      precision.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
      precision.eigenvectors().transpose();
  problem->AddResidualBlock(new ceres::NormalPrior(root, prior.cameras[0].mean),
                            nullptr, camera);
  for (size_t i = 0; i < points->size(); ++i)
    problem->AddResidualBlock(
        NewPriorCost<3>(
            prior.points_mean[i],
            Eigen::Vector3d::Constant(std::sqrt(prior.points_precision))),
        nullptr, (*points)[i].data());
}

Solution SolveByCeres(const std::vector<View>& views,
                      const GaussianPrior& prior, bool fix_points,
                      const AdjustmentState& start) {
  Solution solution;
  solution.camera = start.camera().Parameters();
  solution.points = start.points;
  std::vector<PoseParameters> poses = ToParameters(start.rig_from_pattern);
  ceres::Problem problem;
  for (size_t v = 0; v < views.size(); ++v)
    for (const Observation& o : views[v].observations)
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ReprojectionCost, 2,
                                          OpenCvModel::kCount, 6, 3>(
              new ReprojectionCost{o.pixel}),
          new ceres::HuberLoss(1), solution.camera.data(), poses[v].data(),
          solution.points[o.point].data());
  AddPriorBlocks(prior, solution.camera.data(), &solution.points, &problem);
  if (fix_points)
    for (Eigen::Vector3d& point : solution.points)
      problem.SetParameterBlockConstant(point.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 300;
  options.function_tolerance = 1e-15;
  options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  solution.cost = summary.final_cost;
  for (const PoseParameters& pose : poses)
    solution.poses.push_back(
        {RotationFromVector(pose.head<3>()), pose.tail<3>()});
  return solution;
}

double CostOfPrior(const GaussianPrior& prior, const AdjustmentState& state) {
  const Eigen::VectorXd d = state.camera().Parameters() - prior.cameras[0].mean;
  double cost = d.dot(WeightedPrecision(prior.cameras[0]) * d) / 2;
  for (size_t i = 0; i < state.points.size(); ++i)
    cost += prior.points_precision / 2 *
            (state.points[i] - prior.points_mean[i]).squaredNorm();
  return cost;
}

AdjustmentOptions Thorough(bool fix_points) {
  AdjustmentOptions options;
  options.fix_points = fix_points;
  options.max_iterations = 200;
  options.relative_tolerance = 1e-13;
  options.standstill = 0;
  options.num_threads = 1;
  return options;
}

// Noise, and a few observations in the linear part of the loss.
SmallProblem NoisyProblem(const SmallProblemSizes& sizes) {
  SmallProblem problem = MakeSmallProblem(sizes);
  for (View& view : problem.views)
    view.observations[3].pixel += Eigen::Vector2d(4, -6);
  return problem;
}

void ExpectSameSolution(const Solution& expected,
                        const AdjustmentState& state) {
  const Eigen::VectorXd camera = state.camera().Parameters();
  EXPECT_LT((camera - expected.camera).head<4>().norm(), 1e-2);
  EXPECT_LT((camera - expected.camera).tail<8>().norm(), 1e-3);
  for (size_t i = 0; i < state.points.size(); ++i)
    EXPECT_LT((state.points[i] - expected.points[i]).norm(), 1e-5);
  for (size_t v = 0; v < expected.poses.size(); ++v) {
    const Pose& pose = state.rig_from_pattern[v];
    EXPECT_LT(pose.rotation.angularDistance(expected.poses[v].rotation), 1e-4);
    EXPECT_LT((pose.translation - expected.poses[v].translation).norm(), 1e-4);
  }
}

void ExpectCeresSolution(const SmallProblemSizes& sizes, bool fix_points) {
  const SmallProblem problem = NoisyProblem(sizes);
  const GaussianPrior prior = PriorOf(problem);
  const AdjustmentState start = Disturbed(problem.state, !fix_points);
  const Solution expected =
      SolveByCeres(problem.views, prior, fix_points, start);
  AdjustmentState state = start;
  const AdjustmentSummary summary =
      RunBundleAdjustment(problem.views, prior, Thorough(fix_points), &state);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.final_cost, summary.initial_cost / 10);
  EXPECT_NEAR(summary.final_cost + CostOfPrior(prior, state), expected.cost,
              1e-6 * expected.cost);
  ExpectSameSolution(expected, state);
}

TEST(RunBundleAdjustment, FindsCeresSolutionWithFixedPoints) {
  ExpectCeresSolution({10, 40, 0.3}, true);
}

TEST(RunBundleAdjustment, FindsCeresSolutionWithFreePoints) {
  ExpectCeresSolution({10, 40, 0.3}, false);  // points eliminated
  ExpectCeresSolution({14, 25, 0.3}, false);  // poses eliminated
}

TEST(RunBundleAdjustment, FindsTheTruthWithoutNoise) {
  const SmallProblem problem = MakeSmallProblem({10, 40, 0});
  AdjustmentState state = Disturbed(problem.state, true);
  RunBundleAdjustment(problem.views, PriorOf(problem), Thorough(false), &state);
  for (const Residual& r : ComputeResiduals(state, problem.views, 1))
    EXPECT_LT(r.error_px.norm(), 1e-5);
  EXPECT_LT((state.camera().Parameters() - problem.state.camera().Parameters())
                .cwiseAbs()
                .maxCoeff(),
            1e-3);
}

TEST(RunBundleAdjustment, LeavesWhatIsFixed) {
  const SmallProblem problem = MakeSmallProblem({6, 30, 0.3});
  const AdjustmentState start = Disturbed(problem.state, true);
  AdjustmentOptions options = Thorough(true);
  options.fix_cameras = true;
  AdjustmentState state = start;
  const AdjustmentSummary summary =
      RunBundleAdjustment(problem.views, PriorOf(problem), options, &state);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(state.camera().Parameters(), start.camera().Parameters());
  EXPECT_EQ(state.points, start.points);
}

TEST(RunBundleAdjustment, WorksWithoutAnyPrior) {
  const SmallProblem problem = MakeSmallProblem({10, 40, 0.3});
  AdjustmentState state = Disturbed(problem.state, true);
  const AdjustmentSummary summary = RunBundleAdjustment(
      problem.views, GaussianPrior(), Thorough(false), &state);
  // About 0.09 px^2 a residual.
  EXPECT_LT(summary.final_cost, 0.1 * 10 * 40);
}

TEST(RunBundleAdjustment, ReportsTheResidualsOfItsFinalState) {
  const SmallProblem problem = NoisyProblem({6, 30, 0.3});
  AdjustmentState state = Disturbed(problem.state, false);
  const AdjustmentSummary summary = RunBundleAdjustment(
      problem.views, PriorOf(problem), Thorough(true), &state);
  const auto residuals = ComputeResiduals(state, problem.views, 1);
  double cost = 0;
  ASSERT_EQ(summary.residuals.size(), residuals.size());
  for (size_t i = 0; i < residuals.size(); ++i) {
    EXPECT_EQ(summary.residuals[i].error_px, residuals[i].error_px);
    cost += HuberLoss(residuals[i].error_px.norm(), 1);
  }
  EXPECT_NEAR(summary.final_cost, cost, 1e-9 * cost);
}

TEST(RunBundleAdjustment, StopsWhenAskedWithTheBestStateSoFar) {
  const SmallProblem problem = NoisyProblem({6, 30, 0.3});
  AdjustmentState state = Disturbed(problem.state, true);
  AdjustmentOptions options = Thorough(false);
  std::vector<double> costs;
  options.progress = [&](int iteration, double cost) {
    EXPECT_EQ(iteration, static_cast<int>(costs.size()) + 1);
    costs.push_back(cost);
  };
  options.should_stop = [&] { return costs.size() == 2; };
  const AdjustmentSummary summary =
      RunBundleAdjustment(problem.views, PriorOf(problem), options, &state);
  ASSERT_EQ(summary.num_iterations, 2);
  EXPECT_FALSE(summary.converged);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(summary.final_cost, costs.back());
  AdjustmentState untouched = Disturbed(problem.state, true);
  options.should_stop = [] { return true; };
  GaussianPrior prior = PriorOf(problem);
  OptimizeWithLearnedPrior(problem.views, options, &prior, &untouched);
  EXPECT_EQ(untouched.points, Disturbed(problem.state, true).points);
}

// A board's points at pixels that a lens sees them at, one metre away.
void AddSeenAt(const CameraModel& lens, const Eigen::Vector2d& pixel,
               const Eigen::Vector2d& observed, SmallProblem* problem) {
  const Eigen::Vector3d ray = lens.Unproject(pixel).value();
  problem->views[0].observations.push_back(
      {static_cast<int>(problem->state.points.size()), observed});
  problem->state.points.push_back(ray / ray.z());
}

// From half a pixel beside the true pose, the step to it makes a residual valid
// that is large, which a sum over each state's own residuals would refuse. Its
// loss is linear: there it has a small say.
TEST(RunBundleAdjustment, DoesNotStallWhereResidualsBecomeValid) {
  TestRandom random(5);
  const OpenCvModel wide = ExampleLens().WithArea({-50, -50, 690, 530});
  SmallProblem problem;
  problem.views.resize(1);
  problem.state.SetCamera(wide.WithArea(WholeImage({640, 480})));
  problem.state.rig_from_pattern.resize(1);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn({50, 50, 590, 430});
    AddSeenAt(wide, pixel, pixel, &problem);
  }
  const double edge = -kAdjustmentMarginPx + 0.3;
  AddSeenAt(wide, {edge, 240}, {80, 240}, &problem);

  AdjustmentOptions options = Thorough(true);
  options.fix_cameras = true;
  AdjustmentState state = problem.state;
  state.rig_from_pattern[0].translation.x() -= 0.001;
  const auto cost_of = [&](const AdjustmentState& at) {
    const auto residuals = ComputeResiduals(at, problem.views, 1);
    return CompareCosts(residuals, residuals, options.huber_px);
  };
  const ComparableCosts start = cost_of(state), truth = cost_of(problem.state);
  ASSERT_EQ(start.num_common, 60);
  ASSERT_EQ(truth.num_common, 61);
  ASSERT_GT(truth.second, 5 * start.second);
  RunBundleAdjustment(problem.views, GaussianPrior(), options, &state);
  const auto residuals = ComputeResiduals(state, problem.views, 1);
  for (int i = 0; i < 60; ++i) EXPECT_LT(residuals[i].error_px.norm(), 0.25);
}

// A grid of many parameters, which LargeEquations are for.
struct GridProblem {
  SmallProblem problem = MakeSmallProblem({25, 80, 0.1});
  GaussianPrior prior;

  explicit GridProblem(double knot_spacing_px) {
    const CentralGeneric grid =
        FittedGrid(problem.state.camera(), knot_spacing_px);
    problem.state.SetCamera(grid);
    prior.cameras = {MakeSmoothnessPrior(grid, {})};
    prior.cameras[0].groups[0].weight = 1;
    prior.points_mean = problem.state.points;
    prior.points_precision = 1e5;
  }
};

// Far from Huber's parabola steps shrink by a constant factor: they lower the
// cost by some millionths for a long time.
TEST(RunBundleAdjustment, HasConvergedWhereStepsChangeNothingAnyMore) {
  constexpr double kNoisePx = 2;
  SmallProblem problem = MakeSmallProblem({10, 12, kNoisePx});
  AdjustmentOptions options;
  options.huber_px = 0.01;
  options.num_threads = 1;
  AdjustmentState state = problem.state;
  const AdjustmentSummary summary =
      RunBundleAdjustment(problem.views, PriorOf(problem), options, &state);
  EXPECT_TRUE(summary.converged);
  options.standstill = 0;
  options.relative_tolerance = 1e-10;
  options.max_iterations = 3000;
  const AdjustmentSummary thorough = RunBundleAdjustment(
      problem.views, PriorOf(problem), options, &problem.state);
  EXPECT_TRUE(thorough.converged);
  double moved = 0;
  for (size_t i = 0; i < summary.residuals.size(); ++i)
    moved += (summary.residuals[i].error_px - thorough.residuals[i].error_px)
                 .squaredNorm();
  moved = std::sqrt(moved / static_cast<double>(summary.residuals.size()));
  std::printf("%d iterations, %d; %.4f px apart\n", summary.num_iterations,
              thorough.num_iterations, moved);
  EXPECT_LT(moved, 0.05 * kNoisePx);
}

TEST(RunBundleAdjustment, IsTheSameWithAnyNumberOfThreads) {
  const GridProblem grid(30);
  AdjustmentOptions options;
  options.max_iterations = 5;  // bits that differ do so from the first on
  AdjustmentState states[2] = {grid.problem.state, grid.problem.state};
  for (const int k : {0, 1}) {
    options.num_threads = 1 + k;
    GaussianPrior prior = grid.prior;
    OptimizeWithLearnedPrior(grid.problem.views, options, &prior, &states[k]);
  }
  ASSERT_GT(states[0].camera().NumParameters(), 1000);
  EXPECT_EQ(states[0].camera().Parameters(), states[1].camera().Parameters());
  EXPECT_EQ(states[0].points, states[1].points);
}

// How strong the learned priors are for points that lie off their nominal
// places by this much.
double LearnedPointsWeight(double deviation_m) {
  SmallProblem problem = MakeSmallProblem({20, 60, 0.1});
  GaussianPrior prior = PriorOf(problem);
  prior.points_precision = 0;
  TestRandom random(31);
  for (Eigen::Vector3d& p : prior.points_mean)
    p += deviation_m * random.NormalVector<3>();
  AdjustmentOptions options = Thorough(false);
  options.relative_tolerance = 1e-7;
  OptimizeWithLearnedPrior(problem.views, options, &prior, &problem.state);
  return prior.points_precision;
}

// A grid that is adjusted with a learned prior.
struct LearnedGrid {
  GridProblem grid{30};
  AdjustmentState state = grid.problem.state;
  AdjustmentSummary summary;

  explicit LearnedGrid(const AdjustmentOptions& options) {
    GaussianPrior prior = grid.prior;
    summary =
        OptimizeWithLearnedPrior(grid.problem.views, options, &prior, &state);
  }
};

TEST(OptimizeWithLearnedPrior, EndsOnceItsResidualsAreEnough) {
  AdjustmentOptions options;
  const LearnedGrid whole(options);
  int num_asked = 0;
  std::vector<Residual> told;
  bool should_accept = false;
  options.should_accept = [&](const std::vector<Residual>& residuals) {
    ++num_asked;
    told = residuals;
    return should_accept;
  };
  const LearnedGrid asked(options);
  EXPECT_EQ(num_asked, 1);
  EXPECT_EQ(asked.state.camera().Parameters(),
            whole.state.camera().Parameters());
  should_accept = true;
  const LearnedGrid ended(options);
  EXPECT_EQ(num_asked, 2);
  EXPECT_EQ(ended.summary.num_iterations, 0);
  EXPECT_NE(ended.state.camera().Parameters(),
            whole.state.camera().Parameters());
  ASSERT_EQ(told.size(), ended.summary.residuals.size());
  for (size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(told[i].error_px, ended.summary.residuals[i].error_px);
    EXPECT_LT((told[i].error_px - whole.summary.residuals[i].error_px).norm(),
              0.1);
  }
}

TEST(OptimizeWithLearnedPrior, FindsHowFarPointsLieFromNominal) {
  // The ratio of the variances of a residual's and a point's coordinate.
  for (const double deviation_m : {0.001, 0.003}) {
    const double expected = 0.1 * 0.1 / (deviation_m * deviation_m);
    const double learned = LearnedPointsWeight(deviation_m);
    EXPECT_GT(learned, 0.6 * expected);
    EXPECT_LT(learned, 1.6 * expected);
  }
}

}  // namespace
}  // namespace raygrid
