/// Vectors of four floats with the compiler's vector extensions, so that
/// operations and their order are the same on all machines.
#ifndef RAYGRID_FEATURES_REFINEMENT_FLOAT_LANES_H
#define RAYGRID_FEATURES_REFINEMENT_FLOAT_LANES_H

#include <cstdint>
#include <cstring>

namespace raygrid {

using FloatLanes = float __attribute__((vector_size(16)));
using IntLanes = int32_t __attribute__((vector_size(16)));
constexpr int kLanes = 4;

inline FloatLanes LoadLanes(const float* from) {
  FloatLanes lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

inline float SumLanes(const FloatLanes& lanes) {
  return (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
}

/// A value and its gradient, interpolated bilinearly.
struct SampledLanes {
  FloatLanes value, dx, dy;
};

/// Interpolates at non-negative x and y relative to values[origin]. width: row
/// length. Reads the right and lower neighbours.
inline SampledLanes Bilinear(const float* values, int width, int origin,
                             FloatLanes x, FloatLanes y) {
  const auto ix = __builtin_convertvector(x, IntLanes);
  const auto iy = __builtin_convertvector(y, IntLanes);
  const FloatLanes fx = x - __builtin_convertvector(ix, FloatLanes);
  const FloatLanes fy = y - __builtin_convertvector(iy, FloatLanes);
  const float *p0 = values + (origin + iy[0] * width + ix[0]),
              *p1 = values + (origin + iy[1] * width + ix[1]),
              *p2 = values + (origin + iy[2] * width + ix[2]),
              *p3 = values + (origin + iy[3] * width + ix[3]);
  const auto at = [&](int k) { return FloatLanes{p0[k], p1[k], p2[k], p3[k]}; };
  const FloatLanes corner = at(0), below = at(width);
  const FloatLanes top = at(1) - corner, bottom = at(width + 1) - below;
  const FloatLanes left = corner + fx * top, right = below + fx * bottom;
  return {left + fy * (right - left), top + fy * (bottom - top), right - left};
}

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_FLOAT_LANES_H
