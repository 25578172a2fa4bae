#ifndef RAYGRID_CAMERA_VIEW_PROJECTION_H
#define RAYGRID_CAMERA_VIEW_PROJECTION_H

#include <Eigen/Core>
#include <optional>
#include <string>

#include "camera/equidistant.h"

namespace raygrid {

/// Projections of virtual cameras (formats/SPEC.md, "Views"). Their plane is
/// the image for focal length 1 (pixels per radian in the centre), relative to
/// its centre. The enumerators' values are stored in blobs.
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

/// Projects a direction of any length to the plane; requires
/// ContainsDirection(). In axes of the view: x right, y down, z forward.
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

/// Returns whether the plane has a point for a direction.
bool ContainsDirection(ViewProjection projection,
                       const Eigen::Vector3d& direction);

/// Returns the direction, of any length, of a point of the plane; nullopt for
/// points without one, such as longitudes above 180 degrees.
std::optional<Eigen::Vector3d> PlaneDirection(ViewProjection projection,
                                              const Eigen::Vector2d& point);

/// Returns an angle in radians that measures how much the projection stretches
/// at a direction; stretching is infinite at pi / 2. For a pinhole, the angle
/// from the axis; for a cylinder, from the horizon; for the stereographic
/// projection, half the angle from the axis; for others 0.
double StretchAngle(ViewProjection projection,
                    const Eigen::Vector3d& direction);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_VIEW_PROJECTION_H
