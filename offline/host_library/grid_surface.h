#ifndef RAYGRID_HOST_LIBRARY_GRID_SURFACE_H
#define RAYGRID_HOST_LIBRARY_GRID_SURFACE_H

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "camera/bspline_surface.h"

namespace raygrid {

/// A B-spline surface with N values per control point, N = 2 or 4, arranged for
/// SIMD: four values at a time. It evaluates BSplineSurface's polynomials in
/// Scalar precision.
template <typename Scalar, int N>
class GridSurface {
  static constexpr int kPerLane = 4 / N;  // control points per vector
  static constexpr int kLanes = N;        // vectors per row of four
  using Lane = Eigen::Array<Scalar, 4, 1>;

 public:
  using Value = Eigen::Matrix<Scalar, N, 1>;
  using Pixel = Eigen::Matrix<Scalar, 2, 1>;

  struct Derivatives {
    Value value, by_x, by_y;  ///< per pixel
  };

  GridSurface() = default;
  /// value(k) returns the value of control point k of the surface.
  template <typename ValueOf>
  GridSurface(const BSplineSurface& surface, const ValueOf& value)
      : x0_(static_cast<Scalar>(surface.area().x0)),
        y0_(static_cast<Scalar>(surface.area().y0)),
        cells_per_px_x_(static_cast<Scalar>(1 / surface.cell_width())),
        cells_per_px_y_(static_cast<Scalar>(1 / surface.cell_height())),
        columns_(surface.columns()),
        rows_(surface.rows()) {
    for (int k = 0; k < surface.num_points(); ++k) {
      const Eigen::Matrix<double, N, 1> at = value(k);
      for (int n = 0; n < N; ++n) values_.push_back(static_cast<Scalar>(at[n]));
    }
  }

  Value Evaluate(const Pixel& pixel) const {
    const Position x = Locate(pixel.x(), x0_, cells_per_px_x_, columns_ - 3);
    const Position y = Locate(pixel.y(), y0_, cells_per_px_y_, rows_ - 3);
    const Weights wy = SplineWeights(y.t);
    const Scalar* corner = Corner(x.cell, y.cell);
    Sums sums = WeightedRows(corner, wy);
    return Combine(sums, SplineWeights(x.t));
  }

  Derivatives EvaluateDerivatives(const Pixel& pixel) const {
    const Position x = Locate(pixel.x(), x0_, cells_per_px_x_, columns_ - 3);
    const Position y = Locate(pixel.y(), y0_, cells_per_px_y_, rows_ - 3);
    const Scalar* corner = Corner(x.cell, y.cell);
    const Sums sums = WeightedRows(corner, SplineWeights(y.t));
    const Sums sums_y = WeightedRows(corner, WeightDerivatives(y.t));
    const Weights wx = SplineWeights(x.t);
    return {Combine(sums, wx),
            cells_per_px_x_ * Combine(sums, WeightDerivatives(x.t)),
            cells_per_px_y_ * Combine(sums_y, wx)};
  }

 private:
  struct Position {
    int cell;
    Scalar t;
  };
  struct Weights {
    Scalar w[4];
  };
  struct Sums {
    Lane lane[kLanes];
  };

  static Position Locate(Scalar position, Scalar start, Scalar cells_per_px,
                         int num_cells) {
    const Scalar u = (position - start) * cells_per_px;
    // Truncation differs from floor() for negative u only, which is clamped.
    int cell = static_cast<int>(u);
    cell = cell < 0 ? 0 : cell;
    cell = cell > num_cells - 1 ? num_cells - 1 : cell;
    return {cell, u - static_cast<Scalar>(cell)};
  }

  static Weights SplineWeights(Scalar t) {
    constexpr Scalar kSixth = Scalar(1) / 6;
    const Scalar s = 1 - t, t2 = t * t, s2 = s * s;
    return {{kSixth * s2 * s, kSixth * (t2 * (3 * t - 6) + 4),
             kSixth * (s2 * (3 * s - 6) + 4), kSixth * t2 * t}};
  }
  static Weights WeightDerivatives(Scalar t) {
    constexpr Scalar kHalf = Scalar(1) / 2;
    const Scalar s = 1 - t;
    return {{-kHalf * s * s, kHalf * t * (3 * t - 4), -kHalf * s * (3 * s - 4),
             kHalf * t * t}};
  }

  const Scalar* Corner(int column, int row) const {
    return &values_[static_cast<size_t>(N) * (row * columns_ + column)];
  }

  // Sums over the rows of a 4 x 4 support, for each column of it.
  Sums WeightedRows(const Scalar* corner, const Weights& wy) const {
    Sums sums;
    for (int k = 0; k < kLanes; ++k)
      sums.lane[k] = wy.w[0] * Eigen::Map<const Lane>(corner + 4 * k);
    for (int m = 1; m < 4; ++m) {
      corner += N * columns_;
      for (int k = 0; k < kLanes; ++k)
        sums.lane[k] += wy.w[m] * Eigen::Map<const Lane>(corner + 4 * k);
    }
    return sums;
  }

  static Value Combine(const Sums& sums, const Weights& wx) {
    if constexpr (N == 4) {
      Lane sum = wx.w[0] * sums.lane[0];
      for (int k = 1; k < 4; ++k) sum += wx.w[k] * sums.lane[k];
      return sum.matrix();
    } else {
      const Lane w01(wx.w[0], wx.w[0], wx.w[1], wx.w[1]);
      const Lane w23(wx.w[2], wx.w[2], wx.w[3], wx.w[3]);
      const Lane sum = w01 * sums.lane[0] + w23 * sums.lane[1];
      return Value(sum[0] + sum[2], sum[1] + sum[3]);
    }
  }

  Scalar x0_ = 0, y0_ = 0, cells_per_px_x_ = 0, cells_per_px_y_ = 0;
  int columns_ = 4, rows_ = 4;
  std::vector<Scalar> values_;
};

}  // namespace raygrid

#endif  // RAYGRID_HOST_LIBRARY_GRID_SURFACE_H
