#include "initialization/localization.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace raygrid {
namespace {

constexpr size_t kMinLocalizationMatches = 4;

// A match with its observation line, and the Jacobian of the pixel with respect
// to directions from the line's origin.
struct RayMatch {
  Eigen::Vector3d point;
  Eigen::Vector3d origin, ray;
  Eigen::Matrix<double, 2, 3> pixel_by_ray;
};

std::vector<RayMatch> ComputeObservationRays(
    const CameraModel& camera, const std::vector<PointPixelMatch>& matches) {
  std::vector<RayMatch> ray_matches;
  for (const PointPixelMatch& match : matches) {
    // The distance of 1 m for the linearization is uncritical: the scale
    // depends on it only through the displacement of line origins between
    // pixels.
    const auto line = camera.Line(match.pixel);
    LinearizedProjection projection;
    if (line && camera.Linearize(line->origin + line->direction, &match.pixel,
                                 1, &projection))
      ray_matches.push_back(
          {match.point, line->origin, line->direction, projection.J_point});
  }
  return ray_matches;
}

// Returns the rotation of the mean ray to the z axis. In the rotated frame,
// even a board at a right angle to the optical axis has a perspective image.
Eigen::Quaterniond EstimateMeanRayRotation(
    const std::vector<RayMatch>& ray_matches) {
  Eigen::Vector3d mean(0, 0, 0);
  for (const RayMatch& sight : ray_matches) mean += sight.ray;
  return Eigen::Quaterniond::FromTwoVectors(mean, Eigen::Vector3d::UnitZ());
}

// Returns the power of two close to the board's size in metres, for exact
// scaling.
double ComputeUnit(const std::vector<RayMatch>& ray_matches) {
  double extent = 0;
  for (const RayMatch& sight : ray_matches)
    extent = std::max(extent, (sight.point - ray_matches.front().point).norm());
  return extent > 0 ? std::exp2(std::ceil(std::log2(extent))) : 1;
}

// Estimates a pose from the perspective image of the rays. Lengths are scaled,
// since OpenCV treats points within a few millimetres as identical.
std::optional<Pose> PoseFromPerspective(
    const std::vector<RayMatch>& ray_matches) {
  if (ray_matches.empty()) return std::nullopt;
  const double unit = ComputeUnit(ray_matches);
  const Eigen::Quaterniond facing = EstimateMeanRayRotation(ray_matches);
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const RayMatch& sight : ray_matches) {
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

PoseEquations MakeEquations(const std::vector<RayMatch>& ray_matches,
                            const Pose& pose) {
  PoseEquations equations;
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  for (const RayMatch& sight : ray_matches) {
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
std::optional<Pose> Refine(const std::vector<RayMatch>& ray_matches,
                           Pose pose) {
  constexpr int kMaxSteps = 50;
  constexpr double kTolerance = 1e-12;      // relative decrease of the cost
  constexpr double kNegligiblePx2 = 1e-20;  // cost per ray
  double lambda = 1e-4;
  PoseEquations equations = MakeEquations(ray_matches, pose);
  for (int step = 0; step < kMaxSteps && std::isfinite(equations.cost);
       ++step) {
    Matrix6d damped = equations.matrix;
    damped.diagonal() *= 1 + lambda;
    const Vector6d update = -damped.ldlt().solve(equations.gradient);
    const Pose next = UpdatedPose(pose, update);
    const PoseEquations next_equations = MakeEquations(ray_matches, next);
    const double change = next_equations.cost - equations.cost;
    const bool is_lower = change < 0;
    const bool stands =
        std::abs(change) <=
        kTolerance * equations.cost +
            kNegligiblePx2 * static_cast<double>(ray_matches.size());
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
std::vector<double> ErrorsPx(const std::vector<RayMatch>& ray_matches,
                             const Pose& pose) {
  std::vector<double> errors;
  for (const RayMatch& sight : ray_matches) {
    const Eigen::Vector3d seen = pose * sight.point - sight.origin;
    const Eigen::Vector3d direction = seen.normalized();
    errors.push_back(direction.dot(sight.ray) > 0
                         ? (sight.pixel_by_ray * direction).norm()
                         : INFINITY);
  }
  return errors;
}

double ComputeMedianErrorPx(const std::vector<RayMatch>& ray_matches,
                            const Pose& pose) {
  std::vector<double> errors = ErrorsPx(ray_matches, pose);
  const auto median = errors.begin() + errors.size() / 2;
  std::nth_element(errors.begin(), median, errors.end());
  return *median;
}

// Estimates the pose from all rays and, if most of them are inconsistent with
// it, also from subsets, some of which contain fewer outliers.
std::optional<Pose> EstimateBestPose(const std::vector<RayMatch>& ray_matches) {
  constexpr size_t kParts = 6;
  constexpr double kGoodPx = 1;
  std::optional<Pose> best;
  double best_px = INFINITY;
  const auto optimize_from_start = [&](const std::vector<RayMatch>& part) {
    const auto start = PoseFromPerspective(part);
    const auto pose = start ? Refine(ray_matches, *start) : std::nullopt;
    const double error_px =
        pose ? ComputeMedianErrorPx(ray_matches, *pose) : INFINITY;
    if (pose && (!best || error_px < best_px)) {
      best = pose;
      best_px = error_px;
    }
  };
  optimize_from_start(ray_matches);
  for (size_t first = 0; first < kParts && !(best_px < kGoodPx); ++first) {
    std::vector<RayMatch> part;
    for (size_t i = first; i < ray_matches.size(); i += kParts)
      part.push_back(ray_matches[i]);
    if (part.size() >= kMinLocalizationMatches) optimize_from_start(part);
  }
  return best;
}

// Selects the rays that are inliers for a pose.
std::vector<RayMatch> SelectInliers(const std::vector<RayMatch>& ray_matches,
                                    const Pose& pose) {
  constexpr double kInlierLimitPerMedian = 6, kMinInlierLimitPx = 3;
  const std::vector<double> errors = ErrorsPx(ray_matches, pose);
  const double limit_px =
      std::max(kMinInlierLimitPx,
               kInlierLimitPerMedian * ComputeMedianErrorPx(ray_matches, pose));
  std::vector<RayMatch> consistent;
  for (size_t i = 0; i < ray_matches.size(); ++i)
    if (errors[i] <= limit_px) consistent.push_back(ray_matches[i]);
  return consistent;
}

}  // namespace

std::optional<Pose> Localize(const CameraModel& camera,
                             const std::vector<PointPixelMatch>& matches) {
  constexpr int kMaxRounds = 5;
  std::vector<RayMatch> ray_matches = ComputeObservationRays(camera, matches);
  std::optional<Pose> pose;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (ray_matches.size() < kMinLocalizationMatches) return pose;
    const auto refined = EstimateBestPose(ray_matches);
    if (!refined) return pose;
    pose = refined;
    std::vector<RayMatch> consistent = SelectInliers(ray_matches, *pose);
    if (consistent.size() == ray_matches.size()) break;
    ray_matches = std::move(consistent);
  }
  return pose;
}

}  // namespace raygrid
