#include "experiments/painted_wall.h"

#include <algorithm>
#include <cmath>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr double kUsualDistanceM = 2;

// Returns a deterministic hash of a position, in [0, 1).
double Hash(int64_t x, int64_t y) {
  uint64_t h = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u ^
               static_cast<uint64_t>(y) * 0xc2b2ae3d27d4eb4fu;
  h ^= h >> 29;
  h *= 0xbf58476d1ce4e5b9u;
  h ^= h >> 32;
  return static_cast<double>(h >> 11) * 0x1p-53;
}

double SmoothNoise(double x, double y) {
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double u = ease(x - x0), v = ease(y - y0);
  const auto i = static_cast<int64_t>(x0), j = static_cast<int64_t>(y0);
  const double top = Hash(i, j) + u * (Hash(i + 1, j) - Hash(i, j));
  const double bottom =
      Hash(i, j + 1) + u * (Hash(i + 1, j + 1) - Hash(i, j + 1));
  return top + v * (bottom - top);
}

}  // namespace

// Returns grey levels from 30 to 230.
double PaintedWall::EvaluateTexture(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d place = kUsualDistanceM / distance_m_ * point;
  double level = 0;
  for (const double wave_m : {0.018, 0.04, 0.1})
    level +=
        SmoothNoise(place.x() / wave_m + 1000 * wave_m, place.y() / wave_m) / 3;
  return 30 + 200 * level;
}

std::optional<Eigen::Vector3d> PaintedWall::IntersectRay(
    const ObservationLine& line) const {
  constexpr double kMinSlope = 0.05;
  const Eigen::Vector3d normal(-kSlope, 0, 1);
  const double approach = normal.dot(line.direction);
  if (approach < kMinSlope) return std::nullopt;
  const double depth = (distance_m_ - normal.dot(line.origin)) / approach;
  return Eigen::Vector3d(line.origin + depth * line.direction);
}

cv::Mat PaintedWall::Photograph(const CameraModel& camera,
                                const Pose& wall_from_camera,
                                int num_threads) const {
  const ImageSize& size = camera.image_size();
  cv::Mat levels(size.height, size.width, CV_32F, cv::Scalar(0));
  ParallelFor(size.height, num_threads, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const auto line =
            camera.Line({x - 0.25 + 0.5 * (k % 2), y - 0.25 + 0.5 * (k / 2)});
        if (!line) continue;
        const auto point =
            IntersectRay({wall_from_camera * line->origin,
                          wall_from_camera.rotation * line->direction});
        if (!point) continue;
        sum += EvaluateTexture(*point);
        ++count;
      }
      levels.at<float>(y, x) = static_cast<float>(sum / std::max(1, count));
    }
  });
  return levels;
}

}  // namespace raygrid
