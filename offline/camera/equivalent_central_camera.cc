#include "camera/equivalent_central_camera.h"

#include <cmath>

namespace raygrid {
namespace {

// Returns the distance along an observation line to the scene surface; for a
// sphere, to the far intersection.
std::optional<double> FindDistanceOnLine(const ObservationLine& line,
                                         const SceneSurface& scene) {
  if (scene.normal) {
    const double rise = scene.normal->dot(line.direction);
    const double t = (scene.distance_m - scene.normal->dot(line.origin)) / rise;
    return t > 0 && std::isfinite(t) ? std::optional(t) : std::nullopt;
  }
  const double along = line.direction.dot(line.origin);
  const double square = along * along - line.origin.squaredNorm() +
                        scene.distance_m * scene.distance_m;
  if (!(square >= 0)) return std::nullopt;
  return std::sqrt(square) - along;
}

}  // namespace

std::optional<Eigen::Vector3d> EquivalentCentralCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  const auto line = camera().Line(pixel);
  const auto t = line ? FindDistanceOnLine(*line, scene_) : std::nullopt;
  if (!t) return std::nullopt;
  return (line->origin + *t * line->direction).normalized();
}

std::optional<double> EquivalentCentralCamera::ComputeSurfaceFactor(
    const Eigen::Vector3d& direction) const {
  const double surface_factor =
      scene_.distance_m /
      (scene_.normal ? scene_.normal->dot(direction) : direction.norm());
  return surface_factor > 0 && std::isfinite(surface_factor)
             ? std::optional(surface_factor)
             : std::nullopt;
}

std::optional<Eigen::Vector2d> EquivalentCentralCamera::Project(
    const Eigen::Vector3d& direction, const Eigen::Vector2d* start,
    double margin_px) const {
  const auto surface_factor = ComputeSurfaceFactor(direction);
  if (!surface_factor) return std::nullopt;
  return camera().Project(*surface_factor * direction, start, margin_px);
}

bool EquivalentCentralCamera::Linearize(
    const Eigen::Vector3d& direction, const Eigen::Vector2d* start,
    double margin_px, LinearizedProjection* projection) const {
  const auto surface_factor = ComputeSurfaceFactor(direction);
  if (!surface_factor || !camera().Linearize(*surface_factor * direction, start,
                                             margin_px, projection))
    return false;
  // Derivative of the surface point with respect to the direction.
  const Eigen::Vector3d unit = direction.normalized();
  const Eigen::RowVector3d off =
      scene_.normal ? Eigen::RowVector3d(scene_.normal->transpose() /
                                         scene_.normal->dot(direction))
                    : Eigen::RowVector3d(unit.transpose() / direction.norm());
  const Eigen::Matrix3d J_direction =
      *surface_factor * (Eigen::Matrix3d::Identity() - direction * off);
  projection->J_point = (projection->J_point * J_direction).eval();
  ForgetParameters(projection);
  return true;
}

}  // namespace raygrid
