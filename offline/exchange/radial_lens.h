/// Lenses of photographers' programs: an ideal projection, and a polynomial of
/// the radius with odd powers, too.
#ifndef RAYGRID_EXCHANGE_RADIAL_LENS_H
#define RAYGRID_EXCHANGE_RADIAL_LENS_H

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "exchange/lens_form.h"

namespace raygrid {

/// Ideal projections: the radius of a ray at theta off the axis, in focal
/// lengths.
enum class RadialProjection {
  kRectilinear,    ///< tan(theta)
  kEquidistant,    ///< theta
  kEquisolid,      ///< 2 sin(theta / 2)
  kStereographic,  ///< 2 tan(theta / 2)
  kOrthographic,   ///< sin(theta)
  kThoby           ///< 1.47 sin(0.713 theta)
};

/// A ray whose ideal radius is r focal lengths is seen at r (1 + c1 r + c2 r^2
/// + c3 r^3 + c4 r^4) from the centre.
struct RadialLens {
  Eigen::Vector2d focal_px{0, 0}, center_px{0, 0};
  RadialProjection projection = RadialProjection::kRectilinear;
  std::array<double, 4> coefficients = {};  ///< c1 to c4
};

/// The form of such a lens in tables. It stands for a grid.
LensForm RadialLensForm(const std::string& name);

/// The lens itself where a model of raygrid has it: rectilinear or equidistant,
/// with c1 and c3 of 0. Else the nearest grid, and a remark on its error. name
/// is used there, and is that of the form. Throws InputError for numbers that
/// are no lens, and without a size.
ConvertedLens MakeRadialLens(const std::string& name, const ImageSize& size,
                             const RadialLens& lens,
                             std::vector<std::string>* warnings);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_RADIAL_LENS_H
