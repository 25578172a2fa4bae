/// A projection factor in the style of GTSAM, without GTSAM: the
/// error of a pixel, and its Jacobians with respect to the local coordinates
/// (rotation vector, translation) of world_from_camera and to the point. Reads
/// a camera.yaml and compares them with differences.
///   projection_factor camera.yaml
#include <raygrid_host/camera.h>

#include <algorithm>
#include <cstdio>

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix26d = Eigen::Matrix<double, 2, 6>;
using Matrix23d = Eigen::Matrix<double, 2, 3>;

class ProjectionFactor {
 public:
  ProjectionFactor(const raygrid::CameraD& camera, const Eigen::Vector2d& pixel)
      : camera_(camera), pixel_(pixel) {}

  // Returns whether the point is visible; as a factor, it is inactive if not.
  bool EvaluateError(const Eigen::Isometry3d& world_from_camera,
                     const Eigen::Vector3d& point, Eigen::Vector2d* error,
                     Matrix26d* J_pose = nullptr,
                     Matrix23d* J_world = nullptr) const {
    const Eigen::Vector3d seen = world_from_camera.inverse() * point;
    Eigen::Vector2d pixel;
    Matrix23d J_point;
    if (!camera_.Project(seen, &pixel, &J_point)) return false;
    *error = pixel - pixel_;
    if (J_pose) {
      // seen = exp(-w) (R^T (point - t)) - v to first order
      Eigen::Matrix3d cross;
      cross << 0, -seen.z(), seen.y(), seen.z(), 0, -seen.x(), -seen.y(),
          seen.x(), 0;
      *J_pose << J_point * cross, -J_point;
    }
    if (J_world) *J_world = J_point * world_from_camera.linear().transpose();
    return true;
  }

 private:
  raygrid::CameraD camera_;
  Eigen::Vector2d pixel_;
};

// The pose moved by local coordinates: R exp(w), t + R v.
Eigen::Isometry3d Retract(const Eigen::Isometry3d& pose, const Vector6d& by) {
  const Eigen::Vector3d w = by.head<3>();
  Eigen::Isometry3d moved = pose;
  if (w.norm() > 0)
    moved.linear() =
        pose.linear() *
        Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  moved.translation() += pose.linear() * by.tail<3>();
  return moved;
}

}  // namespace

int main(int argc, char** argv) {
  std::string error = "usage: projection_factor camera.yaml";
  const auto camera =
      argc == 2 ? raygrid::CameraD::Load(argv[1], &error) : std::nullopt;
  if (!camera) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  const Eigen::Isometry3d pose =
      Eigen::Translation3d(0.4, -0.2, 0.1) *
      Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, -1).normalized());
  const Eigen::Vector2d pixel = camera->Bounds().center() * 0.8;
  Eigen::Vector3d origin, bearing;
  if (!camera->UnprojectLine(pixel, &origin, &bearing)) return 1;
  const Eigen::Vector3d point = pose * (origin + 2 * bearing);

  const ProjectionFactor factor(*camera, pixel);
  Eigen::Vector2d at;
  Matrix26d J_pose;
  Matrix23d J_point;
  if (!factor.EvaluateError(pose, point, &at, &J_pose, &J_point)) return 1;
  Eigen::Matrix<double, 2, 9> J;
  J << J_pose, J_point;
  constexpr double kStep = 1e-6;
  double difference = at.norm();
  for (int k = 0; k < 9; ++k) {
    using Vector9d = Eigen::Matrix<double, 9, 1>;
    const Vector9d change = kStep * Vector9d::Unit(k);
    const Vector6d move = change.head<6>();
    const Eigen::Vector3d shift = change.tail<3>();
    Eigen::Vector2d ahead, behind;
    if (!factor.EvaluateError(Retract(pose, move), point + shift, &ahead) ||
        !factor.EvaluateError(Retract(pose, -move), point - shift, &behind))
      return 1;
    difference = std::max(difference,
                          ((ahead - behind) / (2 * kStep) - J.col(k)).norm());
  }
  std::printf("Jacobians differ by at most %.1e px\n", difference);
  return difference < 1e-4 ? 0 : 1;
}
