#ifndef RAYGRID_HOST_LIBRARY_BATCH_H
#define RAYGRID_HOST_LIBRARY_BATCH_H

#include <limits>

#include "host_library/evaluator.h"

namespace raygrid::host {

/// Evaluator's functions of arrays, for an evaluator whose type is known, so
/// that the compiler inlines it.
template <typename Scalar, typename Kind>
int UnprojectArray(const Kind& evaluator, Columns<const Scalar> pixels,
                   int count, Columns<Scalar> origins,
                   Columns<Scalar> bearings) {
  int num_defined = 0;
  for (int k = 0; k < count; ++k) {
    const Vec2<Scalar> pixel(pixels[k][0], pixels[k][1]);
    Vec3<Scalar> origin, bearing;
    const bool is_defined =
        origins.data ? evaluator.UnprojectLine(pixel, &origin, &bearing,
                                               nullptr, nullptr)
                     : evaluator.Unproject(pixel, &bearing, nullptr);
    num_defined += is_defined;
    if (!is_defined) {
      bearing.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
      origin = bearing;
    }
    Eigen::Map<Vec3<Scalar>>{bearings[k]} = bearing;
    if (origins.data) Eigen::Map<Vec3<Scalar>>{origins[k]} = origin;
  }
  return num_defined;
}

template <typename Scalar, typename Kind>
int ProjectArray(const Kind& evaluator, Columns<const Scalar> points, int count,
                 Columns<Scalar> pixels) {
  int num_defined = 0;
  for (int k = 0; k < count; ++k) {
    const Vec3<Scalar> point(points[k][0], points[k][1], points[k][2]);
    Vec2<Scalar> pixel;
    const bool is_defined = evaluator.Project(point, &pixel, nullptr);
    num_defined += is_defined;
    if (!is_defined)
      pixel.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
    Eigen::Map<Vec2<Scalar>>{pixels[k]} = pixel;
  }
  return num_defined;
}

}  // namespace raygrid::host

#endif  // RAYGRID_HOST_LIBRARY_BATCH_H
