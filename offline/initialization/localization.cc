#include "initialization/localization.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace raygrid {
namespace {

constexpr size_t kMinSights = 4;

// A match with its observation line, and the Jacobian of the pixel with respect
// to directions from the line's origin.
struct Sight {
  Eigen::Vector3d point;
  Eigen::Vector3d origin, ray;
  Eigen::Matrix<double, 2, 3> pixel_by_ray;
};

std::vector<Sight> ComputeObservationRays(
    const CameraModel& camera, const std::vector<PointPixelMatch>& matches) {
  std::vector<Sight> sights;
  for (const PointPixelMatch& match : matches) {
    // The distance of 1 m for the linearization is uncritical: the scale
    // depends on it only through the displacement of line origins between
    // pixels.
    const auto line = camera.Line(match.pixel);
    LinearizedProjection projection;
    if (line && camera.Linearize(line->origin + line->direction, &match.pixel,
                                 1, &projection))
      sights.push_back(
          {match.point, line->origin, line->direction, projection.J_point});
  }
  return sights;
}

// Returns the rotation of the mean ray to the z axis. In the rotated frame,
// even a board at a right angle to the optical axis has a perspective image.
Eigen::Quaterniond EstimateMeanRayRotation(const std::vector<Sight>& sights) {
  Eigen::Vector3d mean(0, 0, 0);
  for (const Sight& sight : sights) mean += sight.ray;
  return Eigen::Quaterniond::FromTwoVectors(mean, Eigen::Vector3d::UnitZ());
}

// Returns the power of two close to the board's size in metres, for exact
// scaling.
double ComputeUnit(const std::vector<Sight>& sights) {
  double extent = 0;
  for (const Sight& sight : sights)
    extent = std::max(extent, (sight.point - sights.front().point).norm());
  return extent > 0 ? std::exp2(std::ceil(std::log2(extent))) : 1;
}

// Estimates a pose from the perspective image of the rays. Lengths are scaled,
// since OpenCV treats points within a few millimetres as identical.
std::optional<Pose> PoseFromPerspective(const std::vector<Sight>& sights) {
  if (sights.empty()) return std::nullopt;
  const double unit = ComputeUnit(sights);
  const Eigen::Quaterniond facing = EstimateMeanRayRotation(sights);
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

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Cost of a pose (Huber loss of the reprojection errors with a threshold of 1
// px), and its Gauss-Newton equations for the update of UpdatedPose(). Errors
// are first-order in the angle between ray and point; J_ray does not depend on
// lengths.
struct PoseEquations {
  double cost = 0;
  Vector6d gradient = Vector6d::Zero();
  Matrix6d matrix = Matrix6d::Zero();
};

PoseEquations MakeEquations(const std::vector<Sight>& sights,
                            const Pose& pose) {
  PoseEquations equations;
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  for (const Sight& sight : sights) {
    const Eigen::Vector3d rotated = rotation * sight.point;
    const Eigen::Vector3d seen = rotated + pose.translation - sight.origin;
    const double distance = seen.norm();
    const Eigen::Vector3d direction = seen / distance;
    const Eigen::Vector2d error = sight.pixel_by_ray * direction;
    const double norm = error.norm();
    const double weight = norm <= 1 ? 1 : 1 / norm;
    equations.cost += norm <= 1 ? norm * norm / 2 : norm - 0.5;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d J_ray = sight.pixel_by_ray.row(k);
      const Eigen::Vector3d J_point = (J_ray - error[k] * direction) / distance;
      Vector6d J_pose;
      J_pose << rotated.cross(J_point), J_point;
      equations.gradient += (weight * error[k]) * J_pose;
      equations.matrix += (weight * J_pose) * J_pose.transpose();
    }
  }
  return equations;
}

// Refines a pose by the Levenberg-Marquardt method.
std::optional<Pose> Refine(const std::vector<Sight>& sights, Pose pose) {
  constexpr int kMaxSteps = 50;
  constexpr double kTolerance = 1e-12;      // relative decrease of the cost
  constexpr double kNegligiblePx2 = 1e-20;  // cost per ray
  double lambda = 1e-4;
  PoseEquations equations = MakeEquations(sights, pose);
  for (int step = 0; step < kMaxSteps && std::isfinite(equations.cost);
       ++step) {
    Matrix6d damped = equations.matrix;
    damped.diagonal() *= 1 + lambda;
    const Vector6d update = -damped.ldlt().solve(equations.gradient);
    const Pose next = UpdatedPose(pose, update);
    const PoseEquations next_equations = MakeEquations(sights, next);
    const double change = next_equations.cost - equations.cost;
    const bool is_lower = change < 0;
    const bool stands = std::abs(change) <=
                        kTolerance * equations.cost +
                            kNegligiblePx2 * static_cast<double>(sights.size());
    if (is_lower) {
      pose = next;
      equations = next_equations;
    }
    if (stands) break;
    lambda *= is_lower ? 0.1 : 10;
  }
  if (!std::isfinite(equations.cost) || !pose.rotation.coeffs().allFinite())
    return std::nullopt;
  return pose;
}

// Returns the first-order reprojection errors of a pose in pixels.
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

double ComputeMedianErrorPx(const std::vector<Sight>& sights,
                            const Pose& pose) {
  std::vector<double> errors = ErrorsPx(sights, pose);
  const auto median = errors.begin() + errors.size() / 2;
  std::nth_element(errors.begin(), median, errors.end());
  return *median;
}

// Estimates the pose from all rays and, if most of them are inconsistent with
// it, also from subsets, some of which contain fewer outliers.
std::optional<Pose> EstimateBestPose(const std::vector<Sight>& sights) {
  constexpr size_t kParts = 6;
  constexpr double kGoodPx = 1;
  std::optional<Pose> best;
  double best_px = INFINITY;
  const auto try_start = [&](const std::vector<Sight>& part) {
    const auto start = PoseFromPerspective(part);
    const auto pose = start ? Refine(sights, *start) : std::nullopt;
    const double error_px =
        pose ? ComputeMedianErrorPx(sights, *pose) : INFINITY;
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

// Selects the rays that are inliers for a pose.
std::vector<Sight> Consistent(const std::vector<Sight>& sights,
                              const Pose& pose) {
  constexpr double kTimesMedian = 6, kAlwaysPx = 3;
  const std::vector<double> errors = ErrorsPx(sights, pose);
  const double limit_px =
      std::max(kAlwaysPx, kTimesMedian * ComputeMedianErrorPx(sights, pose));
  std::vector<Sight> consistent;
  for (size_t i = 0; i < sights.size(); ++i)
    if (errors[i] <= limit_px) consistent.push_back(sights[i]);
  return consistent;
}

}  // namespace

std::optional<Pose> Localize(const CameraModel& camera,
                             const std::vector<PointPixelMatch>& matches) {
  constexpr int kMaxRounds = 5;
  std::vector<Sight> sights = ComputeObservationRays(camera, matches);
  std::optional<Pose> pose;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (sights.size() < kMinSights) return pose;
    const auto refined = EstimateBestPose(sights);
    if (!refined) return pose;
    pose = refined;
    std::vector<Sight> consistent = Consistent(sights, *pose);
    if (consistent.size() == sights.size()) break;
    sights = std::move(consistent);
  }
  return pose;
}

}  // namespace raygrid
