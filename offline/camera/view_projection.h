#ifndef RAYGRID_CAMERA_VIEW_PROJECTION_H
#define RAYGRID_CAMERA_VIEW_PROJECTION_H

#include <Eigen/Core>
#include <optional>
#include <string>

#include "camera/equidistant.h"

namespace raygrid {

/// How a virtual camera shows directions (formats/SPEC.md, "Views"). Its plane
/// is the image of focal length 1 around its centre, in pixels per radian
/// there. The numbers are those of blobs.
enum class ViewProjection {
  kPinhole,
  kCylindrical,      ///< around the y axis
  kEquirectangular,  ///< longitude and latitude
  kStereographic,
  kEquidistant
};

/// "pinhole", "cylindrical", "equirectangular", "stereographic", "equidistant".
const char* ProjectionName(ViewProjection projection);
std::optional<ViewProjection> FindProjection(const std::string& name);

/// The point of the plane at which a direction of any length is seen, where
/// ShowsDirection() says that it is. In axes of the view: x right, y down, z
/// forward.
template <typename T>
Eigen::Matrix<T, 2, 1> PlanePoint(ViewProjection projection,
                                  const Eigen::Matrix<T, 3, 1>& direction) {
  using std::atan2;
  using std::sqrt;
  const T &x = direction.x(), &y = direction.y(), &z = direction.z();
  switch (projection) {
    case ViewProjection::kPinhole:
      return {x / z, y / z};
    case ViewProjection::kCylindrical:
      return {atan2(x, z), y / sqrt(x * x + z * z)};
    case ViewProjection::kEquirectangular:
      return {atan2(x, z), atan2(y, sqrt(x * x + z * z))};
    case ViewProjection::kStereographic: {
      const T half = 0.5 * (sqrt(x * x + y * y + z * z) + z);
      return {x / half, y / half};
    }
    case ViewProjection::kEquidistant:
      break;
  }
  return ToEquidistant(direction);
}

/// Whether the plane has a point for a direction.
bool ShowsDirection(ViewProjection projection,
                    const Eigen::Vector3d& direction);

/// The direction, of any length, that a point of the plane looks along; nothing
/// for points that look nowhere, such as those of longitudes above 180 degrees.
std::optional<Eigen::Vector3d> PlaneDirection(ViewProjection projection,
                                              const Eigen::Vector2d& point);

/// An angle in radians that says how much the projection stretches what is seen
/// along a direction: it grows to pi / 2 where that becomes infinite. Of a
/// pinhole it is the angle from the axis, of a cylinder that from the horizon,
/// of the stereographic projection half the angle from the axis, of others 0.
double StretchAngle(ViewProjection projection,
                    const Eigen::Vector3d& direction);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_VIEW_PROJECTION_H
