#include "camera/view_projection.h"

#include <array>

namespace raygrid {
namespace {

constexpr std::array<const char*, 5> kNames = {"pinhole", "cylindrical",
                                               "equirectangular",
                                               "stereographic", "equidistant"};

}  // namespace

const char* ProjectionName(ViewProjection projection) {
  return kNames[static_cast<size_t>(projection)];
}

std::optional<ViewProjection> FindProjection(const std::string& name) {
  for (size_t k = 0; k < kNames.size(); ++k)
    if (name == kNames[k]) return static_cast<ViewProjection>(k);
  return std::nullopt;
}

bool ContainsDirection(ViewProjection projection,
                       const Eigen::Vector3d& direction) {
  constexpr double kLeast = 1e-12;  // relative to the length
  const double length = direction.norm();
  switch (projection) {
    case ViewProjection::kPinhole:
      return direction.z() > 0;
    case ViewProjection::kCylindrical:
    case ViewProjection::kEquirectangular:
      return std::hypot(direction.x(), direction.z()) > kLeast * length;
    case ViewProjection::kStereographic:
    case ViewProjection::kEquidistant:
      break;
  }
  return direction.head<2>().norm() > kLeast * length || direction.z() > 0;
}

std::optional<Eigen::Vector3d> PlaneDirection(ViewProjection projection,
                                              const Eigen::Vector2d& point) {
  const double a = point.x(), b = point.y();
  switch (projection) {
    case ViewProjection::kPinhole:
      return Eigen::Vector3d(a, b, 1);
    case ViewProjection::kCylindrical:
      if (!(std::abs(a) <= M_PI)) return std::nullopt;
      return Eigen::Vector3d(std::sin(a), b, std::cos(a));
    case ViewProjection::kEquirectangular:
      if (!(std::abs(a) <= M_PI) || !(std::abs(b) <= M_PI / 2))
        return std::nullopt;
      return Eigen::Vector3d(std::sin(a) * std::cos(b), std::sin(b),
                             std::cos(a) * std::cos(b));
    case ViewProjection::kStereographic:
      return Eigen::Vector3d(a, b, 1 - point.squaredNorm() / 4);
    case ViewProjection::kEquidistant:
      break;
  }
  if (!(point.norm() <= M_PI)) return std::nullopt;
  return FromEquidistant(point);
}

double StretchAngle(ViewProjection projection,
                    const Eigen::Vector3d& direction) {
  const double from_axis =
      std::atan2(direction.head<2>().norm(), direction.z());
  switch (projection) {
    case ViewProjection::kPinhole:
      return from_axis;
    case ViewProjection::kCylindrical:
      return std::atan2(std::abs(direction.y()),
                        std::hypot(direction.x(), direction.z()));
    case ViewProjection::kStereographic:
      return from_axis / 2;
    case ViewProjection::kEquirectangular:
    case ViewProjection::kEquidistant:
      break;
  }
  return 0;
}

}  // namespace raygrid
