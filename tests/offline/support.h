#ifndef RAYGRID_TESTS_OFFLINE_SUPPORT_H
#define RAYGRID_TESTS_OFFLINE_SUPPORT_H

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "camera/noncentral_generic.h"
#include "camera/opencv.h"
#include "camera/pose.h"
#include "dataset/error.h"
#include "simulation/simulated_camera_models.h"
#include "temporary_folder.h"

namespace raygrid {

/// Numbers with a fixed seed, the same with every standard library.
class TestRandom {
 public:
  explicit TestRandom(unsigned seed) : engine_(seed) {}

  double Uniform(double low, double high) {
    return low + (high - low) * (engine_() / 4294967296.0);
  }
  double Normal() {
    return std::sqrt(-2 * std::log(1 - Uniform(0, 1))) *
           std::cos(Uniform(0, 2 * M_PI));
  }
  template <int N>
  Eigen::Matrix<double, N, 1> NormalVector() {
    Eigen::Matrix<double, N, 1> vector;
    for (int k = 0; k < N; ++k) vector[k] = Normal();
    return vector;
  }
  Eigen::Vector2d PixelIn(const Area& area) {
    const double x = Uniform(area.x0, area.x1);
    return {x, Uniform(area.y0, area.y1)};
  }
  int Index(int count) { return static_cast<int>(Uniform(0, count)); }

 private:
  std::mt19937 engine_;
};

/// Derivative of a vector function by central differences.
template <typename Function>
Eigen::MatrixXd CentralDifference(const Function& function,
                                  const Eigen::VectorXd& at, double step) {
  Eigen::MatrixXd derivative;
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    Eigen::VectorXd forward = at, backward = at;
    forward[k] += step;
    backward[k] -= step;
    const Eigen::VectorXd ahead = function(forward);
    const Eigen::VectorXd behind = function(backward);
    if (k == 0) derivative.resize(ahead.size(), at.size());
    for (Eigen::Index i = 0; i < ahead.size(); ++i)
      derivative(i, k) = (ahead[i] - behind[i]) / (2 * step);
  }
  return derivative;
}

/// The largest difference of two matrices, over the size of the second.
template <typename A, typename B>
double RelativeDifference(const A& a, const B& b) {
  return (a - b).cwiseAbs().maxCoeff() / (1e-12 + b.cwiseAbs().maxCoeff());
}

/// Every coefficient at work; folds well outside the image.
inline OpenCvModel ExampleLens() {
  const ImageSize size = {640, 480};
  return OpenCvModel(
      size, WholeImage(size),
      {510, 515, 322, 236, -0.15, 0.06, 0.01, 0.1, 0.02, 0.005, 1e-3, -8e-4});
}

/// A nearly stereographic fisheye: 100 degrees off axis at the sides, which a
/// wave along the image makes a little uneven.
inline CentralGeneric ExampleFisheye() {
  const ImageSize size = {800, 800};
  BSplineSurface surface(WholeImage(size), 19, 19);
  const double unit = std::tan(50 * M_PI / 180) / (surface.area().width() / 2);
  for (int k = 0; k < surface.num_points(); ++k) {
    const Eigen::Vector2d pixel((k % 19 - 1) * surface.cell_width(),
                                (k / 19 - 1) * surface.cell_height());
    const Eigen::Vector2d wave(std::sin(pixel.y() / 90),
                               std::cos(pixel.x() / 110));
    surface.points()[k] = unit * (pixel - surface.area().center() + 4 * wave);
  }
  return CentralGeneric(size, surface);
}

inline Eigen::Vector3d PointAlong(const ObservationLine& line,
                                  double distance) {
  return line.origin + distance * line.direction;
}

/// A fisheye of 800 x 800 pixels that folds over where it is farther than
/// radius_px from the middle: there it shows again what it shows inside. If
/// radius_px is less than 283, corners are folded twice.
/// mirror: +1, or -1 for a camera whose images are mirrored.
inline CentralGeneric FoldedFisheye(double radius_px, double mirror) {
  const ImageSize size = {800, 800};
  BSplineSurface surface(WholeImage(size), 43, 43);
  for (int k = 0; k < surface.num_points(); ++k) {
    const Eigen::Vector2d offset =
        surface.GetPixel(k) - surface.area().center();
    const double angle = M_PI / 2 * offset.norm() / radius_px;
    const Eigen::Vector2d chart =
        offset / radius_px * (angle > 0 ? std::sin(angle) / angle : 1);
    surface.points()[k] = {mirror * chart.x(), chart.y()};
  }
  return CentralGeneric(size, surface);
}

/// Expects that what a camera of FoldedFisheye() shows inside is projected
/// there from the middle and from any start inside, what it shows in its folds
/// inside or nowhere, and nothing from a start in its fold.
inline void ExpectProjectionIntoFold(const CameraModel& camera,
                                     double radius_px) {
  constexpr double kEdgePx = 15;
  const Eigen::Vector2d center = camera.area().center();
  TestRandom random(12);
  int num_folded = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(camera.area());
    const Eigen::Vector2d start = random.PixelIn(camera.area());
    const double radius = (pixel - center).norm();
    const double start_radius = (start - center).norm();
    if (std::abs(radius - radius_px) < kEdgePx ||
        std::abs(start_radius - radius_px) < kEdgePx)
      continue;
    // Nothing tells a start that is folded twice from one inside.
    const bool has_start = i % 2 == 1 && start_radius < 2 * radius_px - kEdgePx;
    const auto projection = camera.Project(PointAlong(*camera.Line(pixel), 2),
                                           has_start ? &start : nullptr, 0);
    if (has_start && start_radius > radius_px) {
      EXPECT_FALSE(projection) << start.transpose();
    } else if (radius < radius_px) {
      ASSERT_TRUE(projection) << pixel.transpose();
      EXPECT_LT((*projection - pixel).norm(), 1e-6);
    } else {
      ++num_folded;
      EXPECT_TRUE(!projection || (*projection - center).norm() < radius_px)
          << pixel.transpose();
    }
  }
  EXPECT_GT(num_folded, 100);
}

/// The grid nearest to a model over its area.
inline CentralGeneric FittedGrid(const CameraModel& model,
                                 double knot_spacing_px) {
  const Area& area = model.area();
  return FitCentralGeneric(model, area,
                           NumControlPoints(area.width(), knot_spacing_px),
                           NumControlPoints(area.height(), knot_spacing_px));
}

/// Expects that Project() inverts Line() at random pixels.
inline void ExpectRoundTrip(const CameraModel& camera, double tolerance_px) {
  TestRandom random(11);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(camera.area());
    const auto line = camera.Line(pixel);
    ASSERT_TRUE(line) << pixel.transpose();
    EXPECT_NEAR(line->direction.norm(), 1, 1e-12);
    EXPECT_EQ(camera.Unproject(pixel).value(), line->direction);
    const auto projection =
        camera.Project(PointAlong(*line, random.Uniform(0.1, 10)));
    ASSERT_TRUE(projection) << pixel.transpose();
    EXPECT_LT((*projection - pixel).norm(), tolerance_px) << pixel.transpose();
  }
}

/// Expects Linearize()'s derivative by the point to be Project()'s.
inline void ExpectDerivativeByPoint(const CameraModel& camera,
                                    double tolerance) {
  TestRandom random(12);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(camera.area());
    const Eigen::Vector3d point =
        PointAlong(camera.Line(pixel).value(), random.Uniform(0.5, 3));
    LinearizedProjection linear;
    ASSERT_TRUE(camera.Linearize(point, nullptr, 3, &linear));
    EXPECT_LT((linear.pixel - pixel).norm(), 1e-6);
    const auto project = [&](const Eigen::VectorXd& p) -> Eigen::VectorXd {
      return camera.Project(p, nullptr, 3).value();
    };
    EXPECT_LT(RelativeDifference(linear.J_point,
                                 CentralDifference(project, point, 1e-5)),
              tolerance);
  }
}

/// A projection's derivative by all parameters.
inline Eigen::MatrixXd DenseByParameter(const LinearizedProjection& linear,
                                        int num_parameters) {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(2, num_parameters);
  for (int k = 0; k < linear.num_nodes; ++k)
    dense.middleCols(linear.node_parameter[k], linear.num_per_node) +=
        linear.node_weight[k] * linear.J_node.leftCols(linear.num_per_node);
  dense.middleCols(linear.first_global, linear.num_global) +=
      linear.J_global.leftCols(linear.num_global);
  return dense;
}

/// Expects Linearize()'s derivative by every parameter to be that of a camera
/// rebuilt with the parameter changed.
inline void ExpectDerivativeByParameter(const CameraModel& camera, double step,
                                        double tolerance) {
  TestRandom random(13);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(camera.area());
    const Eigen::Vector3d point = PointAlong(camera.Line(pixel).value(), 1);
    LinearizedProjection linear;
    ASSERT_TRUE(camera.Linearize(point, nullptr, 3, &linear));
    const auto project = [&](const Eigen::VectorXd& p) -> Eigen::VectorXd {
      const std::unique_ptr<CameraModel> changed = camera.Clone();
      changed->SetParameters(p);
      return changed->Project(point, &pixel, 3).value();
    };
    EXPECT_LT(RelativeDifference(
                  DenseByParameter(linear, camera.NumParameters()),
                  CentralDifference(project, camera.Parameters(), step)),
              tolerance);
  }
}

/// A lens behind a plate of glass, as a grid.
inline NonCentralGeneric ExampleLines() {
  const ImageSize size = {640, 480};
  const Area area = WholeImage(size);
  return FitNonCentralGeneric(*MakeSimulatedCamera("glass", size), area,
                              NumControlPoints(area.width(), 40),
                              NumControlPoints(area.height(), 40));
}

/// Expects an Error with this code, and a message with these words.
template <typename Function>
void ExpectError(ExitCode code, const std::vector<std::string>& words,
                 const Function& function) {
  try {
    function();
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code))
        << error.what();
    for (const std::string& word : words)
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
          << "'" << word << "' is not in: " << error.what();
  }
}

/// A text with its first such words replaced, which it must have.
inline std::string TextWith(std::string text, const std::string& old,
                            const std::string& by) {
  const size_t at = text.find(old);
  if (at == std::string::npos) {
    ADD_FAILURE() << "nowhere: " << old;
    return text;
  }
  return text.replace(at, old.size(), by);
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_SUPPORT_H
