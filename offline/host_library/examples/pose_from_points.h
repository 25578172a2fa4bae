/// Pose of a camera from points: a minimal solver on bearings in RANSAC, and
/// refinement on observation lines. For central cameras, and for non-central
/// ones whose lines pass within a few per cent of the distance of the points.
#ifndef RAYGRID_EXAMPLES_POSE_FROM_POINTS_H
#define RAYGRID_EXAMPLES_POSE_FROM_POINTS_H

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace examples {

/// A point of the world, and the line on which the camera observes it.
struct LineObservation {
  Eigen::Vector3d point, origin, bearing;
};

using Triple = std::array<const LineObservation*, 3>;

/// The poses camera_from_world from which three points have these bearings,
/// whose origins are ignored: up to four (J. A. Grunert, 1841, in the notation
/// of R. M. Haralick et al., IJCV 1994).
inline std::vector<Eigen::Isometry3d> SolveThreePoints(const Triple& seen) {
  const auto distance2 = [&](int i, int k) {
    return (seen[i]->point - seen[k]->point).squaredNorm();
  };
  const double b2 = distance2(0, 2);
  const double a = distance2(1, 2) / b2, c = distance2(0, 1) / b2, d = a - c;
  const double ca = seen[1]->bearing.dot(seen[2]->bearing);
  const double cb = seen[0]->bearing.dot(seen[2]->bearing);
  const double cg = seen[0]->bearing.dot(seen[1]->bearing);
  const double a4 = (d - 1) * (d - 1) - 4 * c * ca * ca;
  const double a3 =
      4 * (d * (1 - d) * cb - (1 - a - c) * ca * cg + 2 * c * ca * ca * cb);
  const double a2 =
      2 * (d * d - 1 + 2 * d * d * cb * cb + 2 * (1 - c) * ca * ca -
           4 * (a + c) * ca * cb * cg + 2 * (1 - a) * cg * cg);
  const double a1 =
      4 * (-d * (1 + d) * cb + 2 * a * cg * cg * cb - (1 - a - c) * ca * cg);
  const double a0 = (1 + d) * (1 + d) - 4 * a * cg * cg;
  std::vector<Eigen::Isometry3d> poses;
  if (!(std::abs(a4) > 1e-12)) return poses;

  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.diagonal(-1).setOnes();
  companion.col(3) << -a0 / a4, -a1 / a4, -a2 / a4, -a3 / a4;
  const Eigen::Vector4cd roots = companion.eigenvalues();
  for (int k = 0; k < 4; ++k) {
    const double v = roots[k].real();
    if (std::abs(roots[k].imag()) > 1e-6 || !(v > 0)) continue;
    const double u =
        ((d - 1) * v * v - 2 * d * cb * v + 1 + d) / (2 * (cg - v * ca));
    const double s1 = std::sqrt(b2 / (1 + v * v - 2 * v * cb));
    if (!(u > 0) || !(s1 > 0)) continue;
    const std::array<double, 3> lengths = {s1, u * s1, v * s1};
    Eigen::Matrix3d world, camera;
    for (int i = 0; i < 3; ++i) {
      world.col(i) = seen[i]->point;
      camera.col(i) = lengths[i] * seen[i]->bearing;
    }
    poses.emplace_back(Eigen::umeyama(world, camera, false));
  }
  return poses;
}

/// Angle between the line of an observation and the direction to its point.
inline double LineError(const Eigen::Isometry3d& pose,
                        const LineObservation& seen) {
  const Eigen::Vector3d sight = pose * seen.point - seen.origin;
  return std::atan2(sight.cross(seen.bearing).norm(), sight.dot(seen.bearing));
}

/// Gauss-Newton on the errors of directions in the planes orthogonal to the
/// bearings, for observations with errors below max_error_rad at the start.
inline Eigen::Isometry3d RefinePose(Eigen::Isometry3d pose,
                                    const std::vector<LineObservation>& all,
                                    double max_error_rad) {
  std::vector<const LineObservation*> used;
  for (const LineObservation& seen : all)
    if (LineError(pose, seen) < max_error_rad) used.push_back(&seen);
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (const LineObservation* seen : used) {
      const Eigen::Vector3d rotated = pose.linear() * seen->point;
      const Eigen::Vector3d sight = rotated + pose.translation() - seen->origin;
      Eigen::Matrix<double, 2, 3> tangent;
      tangent.row(0) = seen->bearing.unitOrthogonal();
      tangent.row(1) = seen->bearing.cross(tangent.row(0).transpose());
      const double norm = sight.norm();
      const Eigen::Vector3d direction = sight / norm;
      const Eigen::Matrix<double, 2, 3> J_sight =
          tangent *
          (Eigen::Matrix3d::Identity() - direction * direction.transpose()) /
          norm;
      Eigen::Matrix3d cross;
      cross << 0, -rotated.z(), rotated.y(), rotated.z(), 0, -rotated.x(),
          -rotated.y(), rotated.x(), 0;
      Eigen::Matrix<double, 2, 6> J;
      J << -J_sight * cross, J_sight;
      H += J.transpose() * J;
      g += J.transpose() * (tangent * direction);
    }
    const Eigen::Matrix<double, 6, 1> step = -H.ldlt().solve(g);
    const Eigen::Vector3d turn = step.head<3>();
    if (turn.norm() > 0)
      pose.linear() =
          Eigen::AngleAxisd(turn.norm(), turn.normalized()) * pose.linear();
    pose.translation() += step.tail<3>();
    if (step.norm() < 1e-13) break;
  }
  return pose;
}

/// The pose that most observations agree with to max_error_rad, refined;
/// nullopt if fewer than six agree with any.
inline std::optional<Eigen::Isometry3d> EstimatePose(
    const std::vector<LineObservation>& all, double max_error_rad,
    int num_samples = 200) {
  if (all.size() < 6) return std::nullopt;
  std::mt19937 random(1);
  Eigen::Isometry3d best;
  int most = 5;
  for (int sample = 0; sample < num_samples; ++sample) {
    const auto pick = [&] { return &all[random() % all.size()]; };
    for (const Eigen::Isometry3d& pose :
         SolveThreePoints({pick(), pick(), pick()})) {
      int count = 0;
      for (const LineObservation& seen : all)
        count += LineError(pose, seen) < max_error_rad;
      if (count <= most) continue;
      most = count;
      best = pose;
    }
  }
  if (most < 6) return std::nullopt;
  // The refined pose decides anew which observations agree.
  return RefinePose(RefinePose(best, all, max_error_rad), all, max_error_rad);
}

}  // namespace examples

#endif  // RAYGRID_EXAMPLES_POSE_FROM_POINTS_H
