#include "camera/turned_camera.h"

namespace raygrid {

std::optional<Eigen::Vector3d> TurnedCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  const auto direction = camera().Unproject(pixel);
  if (!direction) return std::nullopt;
  return turned_from_camera_ * *direction;
}

std::optional<ObservationLine> TurnedCamera::Line(
    const Eigen::Vector2d& pixel) const {
  const auto line = camera().Line(pixel);
  if (!line) return std::nullopt;
  return ObservationLine{turned_from_camera_ * line->origin,
                         turned_from_camera_ * line->direction};
}

std::optional<Eigen::Vector2d> TurnedCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  return camera().Project(turned_from_camera_.conjugate() * point, start,
                          margin_px);
}

bool TurnedCamera::Linearize(const Eigen::Vector3d& point,
                             const Eigen::Vector2d* start, double margin_px,
                             LinearizedProjection* projection) const {
  if (!camera().Linearize(turned_from_camera_.conjugate() * point, start,
                          margin_px, projection))
    return false;
  projection->by_point = (projection->by_point *
                          turned_from_camera_.toRotationMatrix().transpose())
                             .eval();
  ForgetParameters(projection);
  return true;
}

}  // namespace raygrid
