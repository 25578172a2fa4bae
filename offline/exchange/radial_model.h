/// Radial models of photography software: an ideal projection, and a polynomial
/// of the radius with odd and even powers.
#ifndef RAYGRID_EXCHANGE_RADIAL_MODEL_H
#define RAYGRID_EXCHANGE_RADIAL_MODEL_H

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "exchange/external_model.h"

namespace raygrid {

/// Ideal projections: radius of a ray at the angle theta from the axis, in
/// focal lengths.
enum class RadialProjection {
  kRectilinear,    ///< tan(theta)
  kEquidistant,    ///< theta
  kEquisolid,      ///< 2 sin(theta / 2)
  kStereographic,  ///< 2 tan(theta / 2)
  kOrthographic,   ///< sin(theta)
  kThoby           ///< 1.47 sin(0.713 theta)
};

/// A ray with ideal radius r (in focal lengths) is imaged at the radius r (1 +
/// c1 r + c2 r^2 + c3 r^3 + c4 r^4).
struct RadialModel {
  Eigen::Vector2d focal_px{0, 0}, center_px{0, 0};
  RadialProjection projection = RadialProjection::kRectilinear;
  std::array<double, 4> coefficients = {};  ///< c1 to c4
};

/// External model of such a camera, which is approximated by a grid.
ExternalModel MakeRadialExternalModel(const std::string& name);

/// Converts to raygrid's model if exact: rectilinear or equidistant, c1 = c3 =
/// 0. Otherwise fits a grid, and adds a warning with the error. name: of the
/// external model, also used in the warning. Throws InputError for invalid
/// parameters, and if the size is missing.
ConvertedCamera MakeRadialCamera(const std::string& name, const ImageSize& size,
                                 const RadialModel& lens,
                                 std::vector<std::string>* warnings);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_RADIAL_MODEL_H
