#include "adjustment/smoothness_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "camera/decentring.h"
#include "camera/stereographic.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr double kDistance = 0.5;

CentralGeneric Base() { return FittedGrid(ExampleLens(), 80); }

Eigen::VectorXd Start() { return NonCentralGeneric(Base()).Parameters(); }

// A camera's parameters with its points moved: point(direction).
template <typename Point>
Eigen::VectorXd WithPoints(const Point& point) {
  Eigen::VectorXd parameters = Start();
  for (Eigen::Index k = 0; k < parameters.size(); k += 5)
    parameters.segment<3>(k + 2) =
        point(FromChart(parameters.segment<2>(k)), k / 5);
  return parameters;
}

double GroupCost(const CameraPrior& prior, size_t group,
                 const Eigen::VectorXd& parameters) {
  return prior.groups[group].SquaredDistance(parameters - prior.mean);
}

TEST(MakeSmoothnessPrior, LeavesTheLensFree) {
  const CentralGeneric base = Base();
  const CameraPrior prior = MakeSmoothnessPrior(base, {});
  const PriorGroup& group = prior.groups[0];
  ASSERT_EQ(group.free.cols(), 7);
  TestRandom random(3);
  const Eigen::VectorXd moved = group.free * random.NormalVector<7>();
  const double held = moved.dot(group.precision * moved);
  EXPECT_LT(group.SquaredDistance(moved), 0.02 * held);
  const Eigen::VectorXd bent = base.Parameters().cwiseAbs2();
  EXPECT_GT(group.SquaredDistance(bent),
            0.2 * bent.dot(group.precision * bent));
}

// What extrapolated corners do must not move the camera's frame.
TEST(MakeSmoothnessPrior, HoldsTheOrientationOfObservedPixels) {
  const CentralGeneric base = Base();
  const BSplineSurface& grid = base.surface();
  const std::vector<Eigen::Vector2d> observed_px = {grid.area().center()};
  const CameraPrior prior = MakeSmoothnessPrior(base, observed_px);
  const SplineSupport support = grid.Support(observed_px.front());
  constexpr double kTurn = 1e-3;
  Eigen::VectorXd observed = prior.mean, others = prior.mean;
  for (int row = 0; row < grid.rows(); ++row)
    for (int column = 0; column < grid.columns(); ++column) {
      const int k = row * grid.columns() + column;
      const bool is_observed = row >= support.row && row < support.row + 4 &&
                               column >= support.column &&
                               column < support.column + 4;
      (is_observed ? observed : others).segment<2>(2 * k) +=
          ChartRotationDerivative(grid.points()[k]) *
          Eigen::Vector3d(kTurn, 0, 0);
    }
  EXPECT_EQ(prior.OrientationError(others).norm(), 0);
  const Eigen::Vector3d turn = prior.OrientationError(observed);
  EXPECT_GT(std::abs(turn.x()), 0.9 * turn.norm());
  EXPECT_GT(turn.norm(), 0.1 * kTurn);
}

// b of covariance K - R R^T, from signs.
TEST(MakeSmoothnessPrior, ScattersAsItHolds) {
  const CameraPrior prior = MakeSmoothnessPrior(Base(), {});
  const PriorGroup& group = prior.groups[0];
  const Eigen::MatrixXd k = Eigen::MatrixXd(group.precision);
  const Eigen::MatrixXd root = Eigen::LLT<Eigen::MatrixXd>(k).matrixL();
  Eigen::MatrixXd without(root.rows(), root.cols());
  for (Eigen::Index i = 0; i < root.cols(); ++i)
    without.col(i) =
        ProjectOutUnpenalized(group.free, group.unpenalized, root.col(i));
  const Eigen::MatrixXd expected =
      k - group.unpenalized * group.unpenalized.transpose();
  EXPECT_LT((without * without.transpose() - expected).norm(), 1e-9 * k.norm());
}

// A pinhole, whose tangential term p1 moves the farthest corner by so many
// pixels.
constexpr int kP1 = OpenCvModel::kP1;
OpenCvModel TiltedLens(double p1_px) {
  OpenCvModel lens = ExampleLens();
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(OpenCvModel::kCount);
  parameters.head<4>() << 510, 510, 319.5, 239.5;
  lens.SetParameters(parameters);
  parameters[kP1] =
      p1_px / ComputeDecentringDisplacement(lens, lens.area())[kP1];
  lens.SetParameters(parameters);
  return lens;
}
CentralGeneric Tilted(double p1_px) {
  return FittedGrid(TiltedLens(p1_px), 80);
}

// The lens around which a grid lies, whose tilt has a precision; the others are
// free.
BaseModel WithTiltPrecision(double precision) {
  const OpenCvModel lens = TiltedLens(0);
  BaseModel base;
  base.model = std::make_shared<OpenCvModel>(lens);
  const Eigen::VectorXd pixels =
      ComputeDecentringDisplacement(lens, lens.area());
  base.precision = precision * pixels.cwiseAbs2();
  return base;
}

// Nearly: the surface beyond the area is not quite as the directions have it.
TEST(MakeSmoothnessPrior, FreesTheParametersOfItsLens) {
  constexpr double kWeight = 10, kVariance = 0.01;
  const CentralGeneric base = Tilted(0);
  const Eigen::VectorXd tilt = Tilted(1).Parameters() - base.Parameters();
  const auto group_with = [&](double precision) {
    PriorGroup group =
        MakeSmoothnessPrior(base, {}, WithTiltPrecision(precision)).groups[0];
    group.SetPrecision(kWeight, kVariance);
    return group;
  };
  const PriorGroup free = group_with(2), held = group_with(1e9);
  EXPECT_EQ(free.free.cols(), OpenCvModel::kCount);
  EXPECT_EQ(held.rank, free.rank + 2);  // p1 and p2
  const double cost = held.SquaredDistance(tilt);
  EXPECT_LT(free.SquaredDistance(tilt), 0.07 * cost);
}

// A precision counts beside the residuals' variance, however much the group
// weighs.
TEST(MakeSmoothnessPrior, HoldsATiltTheLessTheMoreItWeighs) {
  constexpr double kPrecision = 2e4, kVariance = 0.01;
  const CentralGeneric base = Tilted(0);
  const Eigen::VectorXd tilt = Tilted(1).Parameters() - base.Parameters();
  PriorGroup group =
      MakeSmoothnessPrior(base, {}, WithTiltPrecision(kPrecision)).groups[0];
  group.SetPrecision(1, kVariance);
  const double with_weak = group.SquaredDistance(tilt);
  group.SetPrecision(1000, kVariance);
  EXPECT_LT(group.SquaredDistance(tilt), 0.5 * with_weak);
}

// Displacements of a bump, in pixels, over the area.
BSplineSurface Bump(const Area& area, double height_px) {
  BSplineSurface bump(area, 17, 13);
  for (int k = 0; k < bump.num_points(); ++k)
    bump.points()[k].y() =
        height_px *
        std::exp(-(bump.GetPixel(k) - area.center()).squaredNorm() / 8e4);
  return bump;
}

// A grid's parameters that fit values at pixels.
template <typename Value>
Eigen::VectorXd FittedParameters(const BSplineSurface& surface,
                                 const Value& value) {
  std::vector<SurfaceSample> samples;
  for (const Eigen::Vector2d& pixel : surface.SamplePixels(3))
    samples.push_back({pixel, value(pixel)});
  const BSplineSurface fitted =
      FitSurface(surface.area(), surface.columns(), surface.rows(), samples);
  Eigen::VectorXd parameters(2 * fitted.num_points());
  for (int k = 0; k < fitted.num_points(); ++k)
    parameters.segment<2>(2 * k) = fitted.points()[k];
  return parameters;
}

// How a grid changes with displacements, less the turn in them.
Eigen::VectorXd Displaced(const CentralGeneric& base, const CameraPrior& prior,
                          const BSplineSurface& displacement) {
  const BSplineSurface& surface = base.surface();
  const Eigen::VectorXd moved =
      FittedParameters(surface, [&](const Eigen::Vector2d& pixel) {
        Eigen::Matrix2d by_pixel;
        surface.Evaluate(pixel, &by_pixel);
        return Eigen::Vector2d(by_pixel * displacement.Evaluate(pixel));
      });
  Eigen::MatrixXd turns(moved.size(), 3);
  for (int axis = 0; axis < 3; ++axis)
    turns.col(axis) =
        FittedParameters(surface, [&](const Eigen::Vector2d& pixel) {
          return Eigen::Vector2d(
              ChartRotationDerivative(surface.Evaluate(pixel)).col(axis));
        });
  return moved - turns * (prior.orientation.transpose() * turns).inverse() *
                     (prior.orientation.transpose() * moved);
}

// Units differ by a bump. It costs its factor's square, or what the smoothness
// makes of it, or between them what is cheapest: 1 / (1 + 1 / smooth). The
// smoothness alone is that of a spread of next to nothing.
TEST(MakeSmoothnessPrior, HoldsASpreadByItsDeviation) {
  constexpr double kWeight = 10, kVariance = 0.01;
  const CentralGeneric base = Base();
  const BSplineSurface bump = Bump(base.area(), 0.5);
  const auto cost_with = [&](const BSplineSurface& spread, double times) {
    const CameraPrior prior = MakeSmoothnessPrior(base, {}, {}, {spread});
    PriorGroup group = prior.groups[0];
    group.SetPrecision(kWeight, kVariance);
    return kWeight / kVariance *
           group.SquaredDistance(times * Displaced(base, prior, bump));
  };
  const double smooth = cost_with(Bump(base.area(), 1e-6), 1);
  EXPECT_GT(smooth, 10);
  const double expected = 1 / (1 + 1 / smooth);
  EXPECT_NEAR(cost_with(bump, 1), expected, 0.01 * expected);
  EXPECT_NEAR(cost_with(bump, 2), 4 * expected, 0.04 * expected);
}

// A direction that moves nothing is no number that is none.
TEST(MakeSmoothnessPrior, TakesASpreadOfZeros) {
  const CentralGeneric base = Base();
  const PriorGroup with =
      MakeSmoothnessPrior(base, {}, {}, {Bump(base.area(), 0)}).groups[0];
  EXPECT_TRUE(with.free.allFinite());
  EXPECT_TRUE(with.unpenalized.allFinite());
}

// A grid is turned by 1e-3, and its corners, which hardly any pixel is seen
// through, back by ten times as much: that is a turn all the same.
TEST(MakeSmoothnessPrior, HoldsTheOrientationOfWhatIsSeen) {
  const CentralGeneric base = Base();
  const CameraPrior prior = MakeSmoothnessPrior(base, {});
  const BSplineSurface& surface = base.surface();
  Eigen::VectorXd turned = prior.mean, but_corners = prior.mean;
  for (int k = 0; k < surface.num_points(); ++k) {
    const Eigen::Vector2d step =
        1e-3 * ChartRotationDerivative(surface.points()[k]).col(0);
    const int column = k % surface.columns(), row = k / surface.columns();
    const bool is_corner = (column == 0 || column == surface.columns() - 1) &&
                           (row == 0 || row == surface.rows() - 1);
    turned.segment<2>(2 * k) += step;
    but_corners.segment<2>(2 * k) += (is_corner ? -10 : 1) * step;
  }
  const Eigen::VectorXd error = prior.OrientationError(turned);
  EXPECT_GT(error.norm(), 0);
  EXPECT_LT((prior.OrientationError(but_corners) - error).norm(),
            0.02 * error.norm());
}

TEST(MakeNonCentralPrior, CostsNothingAtItsMean) {
  const CameraPrior prior = MakeNonCentralPrior(Base(), {}, kDistance);
  ASSERT_EQ(prior.groups.size(), 2u);
  EXPECT_EQ(prior.mean, Start());
  EXPECT_EQ(prior.Cost(Start()), 0);
}

TEST(MakeNonCentralPrior, EachGroupSeesItsOwnParameters) {
  const CameraPrior prior = MakeNonCentralPrior(Base(), {}, kDistance);
  TestRandom random(1);
  Eigen::VectorXd directions = Start(), points = Start();
  for (Eigen::Index k = 0; k < directions.size(); k += 5) {
    directions.segment<2>(k) += 1e-3 * random.NormalVector<2>();
    points.segment<3>(k + 2) += 1e-3 * random.NormalVector<3>();
  }
  EXPECT_GT(GroupCost(prior, 0, directions), 0);
  EXPECT_EQ(GroupCost(prior, 1, directions), 0);
  EXPECT_EQ(GroupCost(prior, 0, points), 0);
  EXPECT_GT(GroupCost(prior, 1, points), 0);
  EXPECT_EQ((prior.orientation.transpose() * (points - prior.mean)).norm(), 0);
}

TEST(MakeNonCentralPrior, HoldsDirectionsAsTheCentralOneDoes) {
  const CentralGeneric base = Base();
  const CameraPrior central = MakeSmoothnessPrior(base, {});
  const CameraPrior lines = MakeNonCentralPrior(base, {}, kDistance);
  TestRandom random(2);
  Eigen::VectorXd central_parameters = base.Parameters();
  for (Eigen::Index k = 0; k < central_parameters.size(); ++k)
    central_parameters[k] += 1e-3 * random.Normal();
  CentralGeneric moved = base;
  moved.SetParameters(central_parameters);
  const Eigen::VectorXd parameters = NonCentralGeneric(moved).Parameters();
  const double expected = GroupCost(central, 0, central_parameters);
  EXPECT_NEAR(GroupCost(lines, 0, parameters), expected, 1e-9 * expected);
  EXPECT_EQ(lines.groups[0].rank, central.groups[0].rank);
  EXPECT_DOUBLE_EQ(lines.orientation_precision, central.orientation_precision);
  EXPECT_LT(
      (lines.orientation.transpose() * (parameters - lines.mean) -
       central.orientation.transpose() * (central_parameters - central.mean))
          .norm(),
      1e-12);
}

// K has full rank: parameters that observations do not see must be held. Focal
// lengths and centre, which they do see, are held by little.
TEST(MakeNonCentralPrior, LeavesNoParameterQuiteFree) {
  const CameraPrior prior = MakeNonCentralPrior(Base(), {}, kDistance);
  Eigen::MatrixXd sum =
      Eigen::MatrixXd::Zero(prior.mean.size(), prior.mean.size());
  int rank = 0;
  for (const PriorGroup& group : prior.groups) {
    sum += Eigen::MatrixXd(group.precision);
    rank += group.rank;
  }
  EXPECT_EQ(rank, prior.mean.size() - 7);
  // Scaled to a unit diagonal, since units differ.
  const Eigen::VectorXd scale = sum.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> factor(scale.asDiagonal() * sum *
                                            scale.asDiagonal());
  EXPECT_GT(factor.vectorD().minCoeff(), 1e-6);
}

TEST(MakeNonCentralPrior, PrefersPointsThatDoNotDrift) {
  const CameraPrior prior = MakeNonCentralPrior(Base(), {}, kDistance);
  const auto cost = [&](const auto& point) {
    return GroupCost(prior, 1, WithPoints(point));
  };
  const auto pupil = [](const Eigen::Vector3d& d, Eigen::Index) {
    return Eigen::Vector3d(0, 0, 0.002 * (1 - d.z()));
  };
  // Points that drift along the pupil's lines, which stay the same.
  const auto drifted = [&](const Eigen::Vector3d& d, Eigen::Index k) {
    return Eigen::Vector3d(pupil(d, k) + 0.002 * (k % 2 ? 1 : -1) * d);
  };
  const auto shifted = [&](const Eigen::Vector3d& d, Eigen::Index k) {
    return Eigen::Vector3d(pupil(d, k) + Eigen::Vector3d(0.05, 0, 0));
  };
  EXPECT_GT(cost(drifted), 10 * cost(pupil));
  EXPECT_GT(cost(shifted), 2 * cost(pupil));
}

// Points that move by 2 mm from node to node: along the lines they cost far
// more than across, where they are only rough.
TEST(MakeNonCentralPrior, HoldsPointsInTheirPlacesAlongLines) {
  const CameraPrior prior = MakeNonCentralPrior(Base(), {}, kDistance);
  const auto sign = [](Eigen::Index k) { return k % 2 ? 0.001 : -0.001; };
  const auto along = WithPoints(
      [&](const Eigen::Vector3d& d, Eigen::Index k) -> Eigen::Vector3d {
        return sign(k) * d;
      });
  const auto across = WithPoints(
      [&](const Eigen::Vector3d& d, Eigen::Index k) -> Eigen::Vector3d {
        return sign(k) * d.unitOrthogonal();
      });
  EXPECT_GT(GroupCost(prior, 1, along), 5 * GroupCost(prior, 1, across));
}

TEST(MakeNonCentralPrior, CountsPointsInPixelsAtTheDistance) {
  const auto shifted = WithPoints([](const Eigen::Vector3d&, Eigen::Index) {
    return Eigen::Vector3d(0.001, 0, 0);
  });
  const double near =
      GroupCost(MakeNonCentralPrior(Base(), {}, 0.5), 1, shifted);
  const double far = GroupCost(MakeNonCentralPrior(Base(), {}, 1), 1, shifted);
  EXPECT_NEAR(near, 4 * far, 1e-9 * near);
}

}  // namespace
}  // namespace raygrid
