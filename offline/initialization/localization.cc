#include "initialization/localization.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace raygrid {
namespace {

constexpr size_t kMinSights = 4;

// A match seen along a line, and how a direction near the line's, from its
// origin, moves its pixel.
struct Sight {
  Eigen::Vector3d point;
  Eigen::Vector3d origin, ray;
  Eigen::Matrix<double, 2, 3> pixel_by_ray;
};

std::vector<Sight> FormSights(const CameraModel& camera,
                              const std::vector<PointOnPixel>& matches) {
  std::vector<Sight> sights;
  for (const PointOnPixel& match : matches) {
    // Linearised at a metre's distance, which matters little: what pixels per
    // radian depend on distance by is how fast origins move from pixel to
    // pixel.
    const auto line = camera.Line(match.pixel);
    LinearizedProjection projection;
    if (line && camera.Linearize(line->origin + line->direction, &match.pixel,
                                 1, &projection))
      sights.push_back(
          {match.point, line->origin, line->direction, projection.by_point});
  }
  return sights;
}

// Rotation that turns the rays' mean forward, so that even a board seen at a
// right angle to the axis has a perspective image.
Eigen::Quaterniond FacingRotation(const std::vector<Sight>& sights) {
  Eigen::Vector3d mean(0, 0, 0);
  for (const Sight& sight : sights) mean += sight.ray;
  return Eigen::Quaterniond::FromTwoVectors(mean, Eigen::Vector3d::UnitZ());
}

// About as large as the board, and a power of two, which loses no digits.
double UnitOf(const std::vector<Sight>& sights) {
  double extent = 0;
  for (const Sight& sight : sights)
    extent = std::max(extent, (sight.point - sights.front().point).norm());
  return extent > 0 ? std::exp2(std::ceil(std::log2(extent))) : 1;
}

// OpenCV takes points closer together than some millimetres for a single one,
// so they are told it in another unit than metres.
std::optional<Pose> PoseFromPerspective(const std::vector<Sight>& sights) {
  if (sights.empty()) return std::nullopt;
  const double unit = UnitOf(sights);
  const Eigen::Quaterniond facing = FacingRotation(sights);
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const Sight& sight : sights) {
    const Eigen::Vector3d ray = facing * sight.ray;
    if (ray.z() < 0.1) continue;
    const Eigen::Vector3d point = sight.point / unit;
    points.emplace_back(point.x(), point.y(), point.z());
    pixels.emplace_back(ray.x() / ray.z(), ray.y() / ray.z());
  }
  if (points.size() < 4) return std::nullopt;
  cv::Mat rotation, translation;
  try {
    if (!cv::solvePnP(points, pixels, cv::Mat::eye(3, 3, CV_64F), cv::noArray(),
                      rotation, translation, false, cv::SOLVEPNP_SQPNP))
      return std::nullopt;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  const Eigen::Vector3d r(rotation.ptr<double>());
  const Eigen::Vector3d t(translation.ptr<double>());
  if (!r.allFinite() || !t.allFinite()) return std::nullopt;
  const Eigen::AngleAxisd board_rotation(
      r.norm(), r.norm() > 0 ? Eigen::Vector3d(r.normalized())
                             : Eigen::Vector3d::UnitX());
  return Pose{facing.inverse() * Eigen::Quaterniond(board_rotation),
              facing.inverse() * (unit * t)};
}

// Reprojection error to first order in the angle between ray and point: the
// Jacobian by_ray is blind to lengths.
struct SightError {
  const Sight& sight;

  template <typename T>
  bool operator()(const T* rotation, const T* translation, T* error) const {
    const T point[3] = {T(sight.point.x()), T(sight.point.y()),
                        T(sight.point.z())};
    T rotated[3];
    ceres::AngleAxisRotatePoint(rotation, point, rotated);
    Eigen::Matrix<T, 3, 1> direction(rotated[0] + translation[0],
                                     rotated[1] + translation[1],
                                     rotated[2] + translation[2]);
    direction -= sight.origin.cast<T>();
    direction /= direction.norm();
    const Eigen::Matrix<T, 2, 1> pixels =
        sight.pixel_by_ray.cast<T>() * direction;
    error[0] = pixels[0];
    error[1] = pixels[1];
    return true;
  }
};

std::optional<Pose> Refine(const std::vector<Sight>& sights,
                           const Pose& start) {
  const Eigen::AngleAxisd angle_axis(start.rotation);
  Eigen::Vector3d rotation = angle_axis.angle() * angle_axis.axis();
  Eigen::Vector3d translation = start.translation;
  ceres::Problem problem;
  for (const Sight& sight : sights)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<SightError, 2, 3, 3>(
            new SightError{sight}),
        new ceres::HuberLoss(1), rotation.data(), translation.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || !rotation.allFinite() ||
      !translation.allFinite())
    return std::nullopt;
  return Pose{RotationFromVector(rotation), translation};
}

// Reprojection errors of a pose, to first order as above.
std::vector<double> ErrorsPx(const std::vector<Sight>& sights,
                             const Pose& pose) {
  std::vector<double> errors;
  for (const Sight& sight : sights) {
    const Eigen::Vector3d seen = pose * sight.point - sight.origin;
    const Eigen::Vector3d direction = seen.normalized();
    errors.push_back(direction.dot(sight.ray) > 0
                         ? (sight.pixel_by_ray * direction).norm()
                         : INFINITY);
  }
  return errors;
}

double MedianErrorPx(const std::vector<Sight>& sights, const Pose& pose) {
  std::vector<double> errors = ErrorsPx(sights, pose);
  const auto middle = errors.begin() + errors.size() / 2;
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

// The best pose from all sights; should most of them not agree, also from parts
// of them, which hold fewer outliers.
std::optional<Pose> BestPose(const std::vector<Sight>& sights) {
  constexpr size_t kParts = 6;
  constexpr double kGoodPx = 1;
  std::optional<Pose> best;
  double best_px = INFINITY;
  const auto try_start = [&](const std::vector<Sight>& part) {
    const auto start = PoseFromPerspective(part);
    const auto pose = start ? Refine(sights, *start) : std::nullopt;
    const double error_px = pose ? MedianErrorPx(sights, *pose) : INFINITY;
    if (pose && (!best || error_px < best_px)) {
      best = pose;
      best_px = error_px;
    }
  };
  try_start(sights);
  for (size_t first = 0; first < kParts && !(best_px < kGoodPx); ++first) {
    std::vector<Sight> part;
    for (size_t i = first; i < sights.size(); i += kParts)
      part.push_back(sights[i]);
    if (part.size() >= kMinSights) try_start(part);
  }
  return best;
}

// The sights that a pose does not leave far from where most are.
std::vector<Sight> Consistent(const std::vector<Sight>& sights,
                              const Pose& pose) {
  constexpr double kTimesMedian = 6, kAlwaysPx = 3;
  const std::vector<double> errors = ErrorsPx(sights, pose);
  const double limit_px =
      std::max(kAlwaysPx, kTimesMedian * MedianErrorPx(sights, pose));
  std::vector<Sight> consistent;
  for (size_t i = 0; i < sights.size(); ++i)
    if (errors[i] <= limit_px) consistent.push_back(sights[i]);
  return consistent;
}

}  // namespace

std::optional<Pose> Localize(const CameraModel& camera,
                             const std::vector<PointOnPixel>& matches) {
  constexpr int kMaxRounds = 5;
  std::vector<Sight> sights = FormSights(camera, matches);
  std::optional<Pose> pose;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (sights.size() < kMinSights) return pose;
    const auto refined = BestPose(sights);
    if (!refined) return pose;
    pose = refined;
    std::vector<Sight> consistent = Consistent(sights, *pose);
    if (consistent.size() == sights.size()) break;
    sights = std::move(consistent);
  }
  return pose;
}

}  // namespace raygrid
