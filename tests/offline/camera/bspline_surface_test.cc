#include "camera/bspline_surface.h"

#include <numeric>

#include "support.h"

namespace raygrid {
namespace {

const Area kSurfaceArea = {10, -5, 210, 115};

BSplineSurface RandomSurface() {
  BSplineSurface surface(kSurfaceArea, 11, 8);
  TestRandom random(1);
  for (Eigen::Vector2d& point : surface.points())
    point = random.NormalVector<2>();
  return surface;
}

// A polynomial of degree 3 in x and in y.
Eigen::Vector2d Cubic(const Eigen::Vector2d& pixel) {
  const double x = pixel.x() / 100, y = pixel.y() / 100;
  return {1 + x - 2 * y + x * x * y - 0.7 * x * x * x + 0.2 * y * y * y,
          -x * y + 0.5 * x * x * x * y * y * y - y * y};
}

std::vector<SurfaceSample> CubicSamples(int count) {
  TestRandom random(2);
  std::vector<SurfaceSample> samples;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(kSurfaceArea);
    samples.push_back({pixel, Cubic(pixel)});
  }
  return samples;
}

double Sum(const std::array<double, 4>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(BSplineSurface, WeightsSumToOneAndTheirDerivativesToZero) {
  const BSplineSurface surface = RandomSurface();
  TestRandom random(3);
  for (int i = 0; i < 200; ++i) {
    const SplineSupport support =
        surface.Support(random.PixelIn({0, -15, 220, 125}));
    EXPECT_NEAR(Sum(support.wx), 1, 1e-13);
    EXPECT_NEAR(Sum(support.wy), 1, 1e-13);
    EXPECT_NEAR(Sum(support.dwx), 0, 1e-13);
    EXPECT_NEAR(Sum(support.dwy), 0, 1e-13);
  }
}

TEST(BSplineSurface, WeightsAreNotNegativeWithinTheArea) {
  const BSplineSurface surface = RandomSurface();
  TestRandom random(4);
  for (int i = 0; i < 200; ++i) {
    const SplineSupport support = surface.Support(random.PixelIn(kSurfaceArea));
    for (int k = 0; k < 4; ++k) {
      EXPECT_GE(support.wx[k], 0);
      EXPECT_GE(support.wy[k], 0);
    }
  }
}

TEST(BSplineSurface, SupportStaysOnTheGridAtCornersAndBeyond) {
  const BSplineSurface surface = RandomSurface();
  for (const double x : {-100.0, kSurfaceArea.x0, kSurfaceArea.x1, 400.0}) {
    for (const double y : {-100.0, kSurfaceArea.y0, kSurfaceArea.y1, 400.0}) {
      const SplineSupport support = surface.Support({x, y});
      EXPECT_GE(support.column, 0);
      EXPECT_GE(support.row, 0);
      EXPECT_LE(support.column + 4, surface.columns());
      EXPECT_LE(support.row + 4, surface.rows());
    }
  }
}

TEST(BSplineSurface, DerivativeIsThatOfTheValue) {
  const BSplineSurface surface = RandomSurface();
  const auto value = [&](const Eigen::VectorXd& p) -> Eigen::VectorXd {
    return surface.Evaluate(Eigen::Vector2d(p));
  };
  TestRandom random(5);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn({0, -15, 220, 125});
    Eigen::Matrix2d derivative;
    surface.Evaluate(pixel, &derivative);
    EXPECT_LT((derivative - CentralDifference(value, pixel, 1e-4))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-8);
  }
}

// Second derivatives of the surface by x at a place, by differences of the
// analytic first ones on one side.
Eigen::Vector2d SecondDerivative(const BSplineSurface& surface,
                                 const Eigen::Vector2d& pixel, int axis,
                                 double side) {
  constexpr double kStep = 1e-5;
  Eigen::Matrix2d near, far;
  surface.Evaluate(pixel + side * kStep * Eigen::Vector2d::Unit(axis), &near);
  surface.Evaluate(pixel + side * 2 * kStep * Eigen::Vector2d::Unit(axis),
                   &far);
  return (far.col(axis) - near.col(axis)) / (side * kStep);
}

TEST(BSplineSurface, IsTwiceContinuouslyDifferentiableAcrossCellBorders) {
  const BSplineSurface surface = RandomSurface();
  for (int border = 1; border < surface.columns() - 3; ++border) {
    const Eigen::Vector2d pixel(kSurfaceArea.x0 + border * surface.cell_width(),
                                37);
    const Eigen::Vector2d step(1e-9, 0);
    Eigen::Matrix2d left, right;
    const Eigen::Vector2d jump = surface.Evaluate(pixel + step, &right) -
                                 surface.Evaluate(pixel - step, &left);
    EXPECT_LT(jump.norm(), 1e-8);
    EXPECT_LT((right - left).norm(), 1e-8);
    EXPECT_LT((SecondDerivative(surface, pixel, 0, 1) -
               SecondDerivative(surface, pixel, 0, -1))
                  .norm(),
              1e-6);
  }
}

TEST(BSplineSurface, BorderPolynomialGoesOnBeyondTheArea) {
  const BSplineSurface surface =
      FitSurface(kSurfaceArea, 9, 7, CubicSamples(2000));
  const Eigen::Vector2d outside(kSurfaceArea.x1 + 5, kSurfaceArea.y0 - 4);
  EXPECT_LT((surface.Evaluate(outside) - Cubic(outside)).norm(), 1e-5);
}

TEST(NumControlPoints, MakesCellsNoLongerThanAsked) {
  for (const double extent : {1.0, 39.9, 40.0, 639.0, 640.0, 1023.5}) {
    for (const double cell : {1.5, 20.0, 40.0, 77.7}) {
      const int cells = NumControlPoints(extent, cell) - 3;
      EXPECT_GE(cells, 1);
      EXPECT_LE(extent / cells, cell * (1 + 1e-8));
      if (cells == 1) continue;
      EXPECT_GT(extent / (cells - 1), cell);
    }
  }
}

TEST(FitSurface, ReproducesACubicPolynomial) {
  const BSplineSurface surface =
      FitSurface(kSurfaceArea, 11, 8, CubicSamples(3000));
  TestRandom random(6);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(kSurfaceArea);
    EXPECT_LT((surface.Evaluate(pixel) - Cubic(pixel)).norm(), 1e-6);
  }
}

TEST(FitSurface, GoesOnSmoothlyWhereThereAreNoSamples) {
  // A plane, seen only left of x = 100: the surface is the plane everywhere.
  const auto plane = [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(0.01 * p.x() + 0.02 * p.y(), 1 - 0.03 * p.x());
  };
  TestRandom random(7);
  std::vector<SurfaceSample> samples;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(
        {kSurfaceArea.x0, kSurfaceArea.y0, 100, kSurfaceArea.y1});
    samples.push_back({pixel, plane(pixel)});
  }
  const BSplineSurface surface = FitSurface(kSurfaceArea, 11, 8, samples);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(kSurfaceArea);
    EXPECT_LT((surface.Evaluate(pixel) - plane(pixel)).norm(), 1e-4);
  }
}

TEST(FitSurface, AveragesContradictingSamples) {
  std::vector<SurfaceSample> samples;
  TestRandom random(8);
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(kSurfaceArea);
    samples.push_back({pixel, {1, 0}});
    samples.push_back({pixel, {3, -1}});
  }
  const BSplineSurface surface = FitSurface(kSurfaceArea, 5, 5, samples);
  EXPECT_LT((surface.Evaluate(kSurfaceArea.center()) - Eigen::Vector2d(2, -0.5))
                .norm(),
            1e-6);
}

}  // namespace
}  // namespace raygrid
