#include "evaluation/noncentrality.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace raygrid {
namespace {

constexpr int kSteps = 40;  // along each side

std::vector<ObservationLine> SampleObservationLines(const CameraModel& camera) {
  std::vector<ObservationLine> lines;
  const Area& area = camera.area();
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const auto line = camera.Line({area.x0 + area.width() * i / kSteps,
                                     area.y0 + area.height() * j / kSteps});
      if (line) lines.push_back(*line);
    }
  }
  return lines;
}

}  // namespace

Noncentrality ComputeNoncentrality(const CameraModel& camera) {
  Noncentrality spread;
  if (camera.IsCentral()) return spread;
  // The sum of |(I - d d^T)(c - o)|^2 is minimal at the centre c.
  const std::vector<ObservationLine> lines = SampleObservationLines(camera);
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const ObservationLine& line : lines) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() -
                                   line.direction * line.direction.transpose();
    matrix += across;
    right += across * line.origin;
  }
  spread.nearest_point = matrix.ldlt().solve(right);
  for (const ObservationLine& line : lines) {
    const double distance_m =
        line.direction.cross(line.origin - spread.nearest_point).norm();
    spread.rms_m += distance_m * distance_m;
    spread.max_m = std::max(spread.max_m, distance_m);
  }
  spread.rms_m = std::sqrt(spread.rms_m / static_cast<double>(lines.size()));
  return spread;
}

}  // namespace raygrid
