#include "packing/int16_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace raygrid {
namespace {

int32_t Rounded(double value) {
  return static_cast<int32_t>(
      std::lround(std::clamp(value, -2147483647.0, 2147483647.0)));
}

// Fits the plane through the means of opposite edges, for one coordinate;
// clamped to 32 bits.
void FitPlane(const ControlPoints& points, int c, rg_narrow_grid* narrow) {
  const int right = points.columns - 1, bottom = points.rows - 1;
  const auto mean = [&](int i0, int i1, int j0, int j1) {
    double sum = 0;
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i)
        sum += points.values[2 * (j * (right + 1) + i) + c];
    return sum / ((i1 - i0 + 1) * (j1 - j0 + 1));
  };
  const double across =
      (mean(right, right, 0, bottom) - mean(0, 0, 0, bottom)) / right;
  const double down =
      (mean(0, right, bottom, bottom) - mean(0, right, 0, 0)) / bottom;
  const double center = mean(0, right, 0, bottom);
  narrow->column_step_q29[c] = Rounded(across);
  narrow->row_step_q29[c] = Rounded(down);
  narrow->origin_q29[c] =
      Rounded(center - across * right / 2 - down * bottom / 2);
}

// Returns the residuals of control points relative to the plane.
std::vector<int64_t> ComputePlaneResiduals(const ControlPoints& points,
                                           const rg_narrow_grid& plane) {
  std::vector<int64_t> beyond;
  for (size_t k = 0; k < points.values.size(); ++k) {
    const int64_t i = k / 2 % points.columns;
    const int64_t j = k / 2 / points.columns;
    beyond.push_back(int64_t{points.values[k]} - plane.origin_q29[k % 2] -
                     i * plane.column_step_q29[k % 2] -
                     j * plane.row_step_q29[k % 2]);
  }
  return beyond;
}

}  // namespace

std::optional<Int16Grid> QuantizeToInt16(const ControlPoints& points,
                                         uint32_t max_fraction_bits) {
  Int16Grid narrow;
  for (int c = 0; c < 2; ++c) FitPlane(points, c, &narrow.section);
  const std::vector<int64_t> beyond =
      ComputePlaneResiduals(points, narrow.section);
  int64_t largest = 0;
  for (const int64_t value : beyond)
    largest = std::max(largest, std::abs(value));
  int shift = static_cast<int>(RG_CONTROL_POINT_BITS - max_fraction_bits);
  while (largest >= int64_t{32767} << shift) ++shift;
  if (shift > static_cast<int>(RG_CONTROL_POINT_BITS - RG_NARROW_MIN_BITS))
    return std::nullopt;
  narrow.section.fraction_bits = RG_CONTROL_POINT_BITS - shift;
  for (const int64_t value : beyond)
    narrow.residuals.push_back(
        static_cast<int16_t>((value + (int64_t{1} << (shift - 1))) >> shift));
  return narrow;
}

std::optional<std::vector<Int16Grid>> QuantizeToInt16Together(
    const std::vector<ControlPoints>& grids) {
  uint32_t bits = RG_NARROW_MAX_BITS;
  for (const ControlPoints& points : grids) {
    const std::optional<Int16Grid> narrow = QuantizeToInt16(points);
    if (!narrow) return std::nullopt;
    bits = std::min(bits, narrow->section.fraction_bits);
  }
  std::vector<Int16Grid> alike;
  for (const ControlPoints& points : grids) {
    std::optional<Int16Grid> narrow = QuantizeToInt16(points, bits);
    if (!narrow) return std::nullopt;
    alike.push_back(*std::move(narrow));
  }
  return alike;
}

}  // namespace raygrid
