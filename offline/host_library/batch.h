#ifndef RAYGRID_HOST_LIBRARY_BATCH_H
#define RAYGRID_HOST_LIBRARY_BATCH_H

#include <limits>

#include "host_library/chart.h"

namespace raygrid::host {

/// Evaluator's functions of arrays, for an evaluator whose type is known, so
/// that the compiler inlines it.
template <typename Scalar, typename Evaluator>
int UnprojectArray(const Evaluator& evaluator, const Scalar* pixels, int count,
                   Scalar* origins, Scalar* bearings) {
  int num_defined = 0;
  for (int k = 0; k < count; ++k) {
    const Vec2<Scalar> pixel(pixels[2 * k], pixels[2 * k + 1]);
    Vec3<Scalar> origin, bearing;
    const bool is_defined =
        origins ? evaluator.UnprojectLine(pixel, &origin, &bearing, nullptr,
                                          nullptr)
                : evaluator.Unproject(pixel, &bearing, nullptr);
    num_defined += is_defined;
    if (!is_defined) {
      bearing.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
      origin = bearing;
    }
    Eigen::Map<Vec3<Scalar>>(bearings + 3 * k) = bearing;
    if (origins) Eigen::Map<Vec3<Scalar>>(origins + 3 * k) = origin;
  }
  return num_defined;
}

template <typename Scalar, typename Evaluator>
int ProjectArray(const Evaluator& evaluator, const Scalar* points, int count,
                 Scalar* pixels) {
  int num_defined = 0;
  for (int k = 0; k < count; ++k) {
    const Vec3<Scalar> point(points[3 * k], points[3 * k + 1],
                             points[3 * k + 2]);
    Vec2<Scalar> pixel;
    const bool is_defined = evaluator.Project(point, &pixel, nullptr);
    num_defined += is_defined;
    if (!is_defined)
      pixel.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
    Eigen::Map<Vec2<Scalar>>(pixels + 2 * k) = pixel;
  }
  return num_defined;
}

}  // namespace raygrid::host

#endif  // RAYGRID_HOST_LIBRARY_BATCH_H
