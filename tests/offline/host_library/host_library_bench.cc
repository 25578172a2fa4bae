/// Speed and accuracy of the C++ library beside OpenCV: one table in one run,
/// for people. Times are CPU times of one thread; the best of some repetitions.
///   host_library_bench camera.yaml... [--rays FILE]
/// --rays writes the first camera's points for speed_table.py.
#include <raygrid_host/camera.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

namespace {

using raygrid::Camera;
using raygrid::CameraD;
constexpr int kCount = 200000, kRepetitions = 15;

double CpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) +
         1e-9 * static_cast<double>(now.tv_nsec);
}

// Millions of results per second.
double Speed(int count, const std::function<void()>& run) {
  double least_s = INFINITY;
  for (int k = 0; k < kRepetitions; ++k) {
    const double start_s = CpuSeconds();
    run();
    least_s = std::min(least_s, CpuSeconds() - start_s);
  }
  return count / least_s / 1e6;
}

struct Rays {
  CameraD::Pixels pixels;
  CameraD::Points points;  ///< on their lines, at 1 to 5 m
};

Rays RandomRays(const CameraD& camera) {
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * random() / 4294967296.0;
  };
  Rays rays = {CameraD::Pixels(2, kCount), CameraD::Points(3, kCount)};
  const auto bounds = camera.Bounds();
  for (int k = 0; k < kCount;) {
    const Eigen::Vector2d pixel(uniform(bounds.min().x(), bounds.max().x()),
                                uniform(bounds.min().y(), bounds.max().y()));
    Eigen::Vector3d origin, bearing;
    Eigen::Vector2d back;
    if (!camera.UnprojectLine(pixel, &origin, &bearing)) continue;
    const Eigen::Vector3d point = origin + uniform(1, 5) * bearing;
    if (!camera.Project(point, &back) || (back - pixel).norm() > 1) continue;
    rays.pixels.col(k) = pixel;
    rays.points.col(k++) = point;
  }
  return rays;
}

void PrintRow(const char* what, double unprojections, double projections,
              double error_px) {
  std::printf("| %s | %.1f | %.1f | %.1e |\n", what, unprojections, projections,
              error_px);
}

// Errors are those of Project(Unproject(pixel)).
template <typename Scalar>
void MeasureCamera(const Camera<Scalar>& camera, const Rays& rays,
                   const char* precision) {
  using Pixels = typename Camera<Scalar>::Pixels;
  using Points = typename Camera<Scalar>::Points;
  const Pixels pixels = rays.pixels.cast<Scalar>();
  const Points points = rays.points.cast<Scalar>();
  Points bearings(3, kCount), origins(3, kCount);
  Pixels projections(2, kCount);
  const bool is_central = camera.IsCentral();
  const double unprojections = Speed(kCount, [&] {
    if (is_central)
      camera.UnprojectAll(pixels, bearings);
    else
      camera.UnprojectAllLines(pixels, origins, bearings);
  });
  const double per_s =
      Speed(kCount, [&] { camera.ProjectAll(points, projections); });
  if (is_central) origins.setZero();
  const Points ahead = origins + 2 * bearings;
  camera.ProjectAll(ahead, projections);
  double largest_px = 0;
  for (int k = 0; k < kCount; ++k) {
    const double error_px = (projections.col(k) - pixels.col(k)).norm();
    if (error_px == error_px) largest_px = std::max(largest_px, error_px);
  }
  PrintRow((camera.Model() + ", " + precision).c_str(), unprojections, per_s,
           largest_px);
}

void MeasureJacobians(const CameraD& camera, const Rays& rays) {
  Eigen::Matrix<double, 2, 3> J_point;
  Eigen::Matrix<double, 3, 2> J_pixel;
  Eigen::Vector3d bearing;
  Eigen::Vector2d pixel;
  raygrid::IntrinsicsJacobian<double> J_intrinsics;
  constexpr int kSome = kCount / 10;
  double sum = 0;
  const double with_pixel = Speed(kSome, [&] {
    for (int k = 0; k < kSome; ++k)
      if (camera.Unproject(rays.pixels.col(k), &bearing, &J_pixel))
        sum += J_pixel(0, 0);
  });
  const double with_point = Speed(kSome, [&] {
    for (int k = 0; k < kSome; ++k)
      if (camera.Project(rays.points.col(k), &pixel, &J_point))
        sum += J_point(0, 0);
  });
  const double with_all = Speed(kSome, [&] {
    for (int k = 0; k < kSome; ++k)
      if (camera.Project(rays.points.col(k), &pixel, &J_point, &J_intrinsics))
        sum += J_intrinsics.values(0, 0);
  });
  std::printf("| %s, one at a time with J_pixel, J_point | %.1f | %.1f | |\n",
              camera.Model().c_str(), with_pixel, with_point);
  std::printf("| %s, one at a time with J_point, J_intrinsics | | %.1f | |\n",
              camera.Model().c_str(), with_all);
  if (!(sum == sum)) std::puts("");  // the results are used
}

// OpenCV's functions with the parameters of an opencv camera.
void MeasureOpenCv(const CameraD& camera, const Rays& rays) {
  const Eigen::VectorXd p = camera.Parameters();
  const cv::Mat K =
      (cv::Mat_<double>(3, 3) << p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
  // camera.yaml: k1..k6 p1 p2; OpenCV: k1 k2 p1 p2 k3..k6
  const cv::Mat coefficients = (cv::Mat_<double>(1, 8) << p[4], p[5], p[10],
                                p[11], p[6], p[7], p[8], p[9]);
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels, projections, plane;
  for (int k = 0; k < kCount; ++k) {
    points.emplace_back(rays.points(0, k), rays.points(1, k),
                        rays.points(2, k));
    pixels.emplace_back(rays.pixels(0, k), rays.pixels(1, k));
  }
  const cv::Vec3d zero(0, 0, 0);
  const double per_s = Speed(kCount, [&] {
    cv::projectPoints(points, zero, zero, K, coefficients, projections);
  });
  const double unprojections = Speed(
      kCount, [&] { cv::undistortPoints(pixels, plane, K, coefficients); });
  for (int k = 0; k < kCount; ++k) points[k] = {plane[k].x, plane[k].y, 1};
  cv::projectPoints(points, zero, zero, K, coefficients, projections);
  double largest_px = 0;
  for (int k = 0; k < kCount; ++k)
    largest_px = std::max(largest_px, cv::norm(projections[k] - pixels[k]));
  PrintRow("OpenCV " CV_VERSION ", double", unprojections, per_s, largest_px);
}

void WriteRays(const Rays& rays, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(rays.points.data()),
             static_cast<std::streamsize>(sizeof(double)) * rays.points.size());
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  std::puts(
      "| | million unprojections/s | million projections/s | largest error "
      "px |\n|---|---|---|---|");
  for (int k = 1; k < argc; ++k) {
    std::string error;
    if (std::string(argv[k]) == "--rays") break;
    const auto camera = CameraD::Load(argv[k], &error);
    if (!camera) {
      std::fprintf(stderr, "%s\n", error.c_str());
      return 2;
    }
    const Rays rays = RandomRays(*camera);
    if (k == 1 && argc > 3 && std::string(argv[argc - 2]) == "--rays")
      WriteRays(rays, argv[argc - 1]);
    MeasureCamera(*camera, rays, "double");
    MeasureCamera(camera->Cast<float>(), rays, "float");
    MeasureJacobians(*camera, rays);
    if (camera->Model() == "opencv") MeasureOpenCv(*camera, rays);
  }
  return 0;
}
