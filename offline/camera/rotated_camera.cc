#include "camera/rotated_camera.h"

namespace raygrid {

std::optional<Eigen::Vector3d> RotatedCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  const auto direction = camera().Unproject(pixel);
  if (!direction) return std::nullopt;
  return rotated_from_camera_ * *direction;
}

std::optional<ObservationLine> RotatedCamera::Line(
    const Eigen::Vector2d& pixel) const {
  const auto line = camera().Line(pixel);
  if (!line) return std::nullopt;
  return ObservationLine{rotated_from_camera_ * line->origin,
                         rotated_from_camera_ * line->direction};
}

std::optional<Eigen::Vector2d> RotatedCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  return camera().Project(rotated_from_camera_.conjugate() * point, start,
                          margin_px);
}

bool RotatedCamera::Linearize(const Eigen::Vector3d& point,
                              const Eigen::Vector2d* start, double margin_px,
                              LinearizedProjection* projection) const {
  if (!camera().Linearize(rotated_from_camera_.conjugate() * point, start,
                          margin_px, projection))
    return false;
  projection->J_point = (projection->J_point *
                         rotated_from_camera_.toRotationMatrix().transpose())
                            .eval();
  ForgetParameters(projection);
  return true;
}

}  // namespace raygrid
