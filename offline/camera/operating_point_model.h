#ifndef RAYGRID_CAMERA_OPERATING_POINT_MODEL_H
#define RAYGRID_CAMERA_OPERATING_POINT_MODEL_H

#include <optional>
#include <string>
#include <vector>

#include "camera/central_generic.h"

namespace raygrid {

/// An operating-point variable.
enum class OperatingParameter {
  kLensPosition,  ///< focus distance in dioptres (1 / m)
  kTemperature    ///< sensor temperature in degrees Celsius
};

/// Returns "lens_position" or "temperature", as in options and files.
std::string OperatingParameterName(OperatingParameter condition);
/// Returns "dioptres" or "°C".
std::string OperatingParameterUnit(OperatingParameter condition);
/// Returns nullopt if no variable has this name.
std::optional<OperatingParameter> FindOperatingParameter(
    const std::string& name);

/// Range of an operating-point variable, low < high.
struct OperatingRange {
  OperatingParameter condition = OperatingParameter::kLensPosition;
  double low = 0, high = 1;

  double Center() const { return (low + high) / 2; }
  bool Contains(double value) const { return value >= low && value <= high; }
  /// Returns `count` evenly spaced values from low to high.
  std::vector<double> SampleValues(int count) const;
  /// Formats the range: "0 to 10 dioptres".
  std::string Text() const;
};

/// A value of each operating-point variable, in the order of the ranges.
using OperatingPoint = std::vector<double>;
/// Fixed values of the operating-point variables; nullopt: free.
using FixedOperatingPoint = std::vector<std::optional<double>>;

/// Central grids over ranges of one or two operating-point variables. Each
/// control point is a sum of polynomials of the variables' values v and w,
///   c(v, w) = c_0 + a_1 t + a_2 t^2 + ... + b_1 u + b_2 u^2 + ...,
/// with t = (v - mid-range) / half range, and u computed from w in the same
/// way, so that t and u are -1 to 1 over the ranges. All grids have the same
/// area.
class OperatingPointModel {
 public:
  static constexpr int kMaxConditions = 2, kMaxOrder = 3;

  /// A constant camera; orders are the degrees of the ranges' polynomials.
  OperatingPointModel(std::vector<OperatingRange> ranges,
                      std::vector<int> orders, const CentralGeneric& camera);

  const std::vector<OperatingRange>& ranges() const { return ranges_; }
  const std::vector<int>& orders() const { return orders_; }
  OperatingPoint Center() const;
  const ImageSize& image_size() const { return image_size_; }

  /// c_0, then the terms of each range, starting with the first power; all have
  /// the same shape.
  const std::vector<BSplineSurface>& terms() const { return terms_; }
  std::vector<BSplineSurface>& terms() { return terms_; }
  /// Returns the index of a range's first power in terms().
  int FirstTerm(size_t range) const;

  /// Returns the factors of the terms: 1, t, t^2, ..., u, u^2, ... Values may
  /// lie outside the ranges.
  std::vector<double> EvaluateBasis(const OperatingPoint& values) const;

  /// Returns the camera at `values`; polynomials are extrapolated.
  CentralGeneric At(const OperatingPoint& values) const;

  /// Returns the model over the variables that are not fixed.
  OperatingPointModel FixValues(const FixedOperatingPoint& at) const;
  /// Returns the model over one range, with the other at its mid-range.
  OperatingPointModel SliceAlong(size_t range) const;

  /// Returns the model with an additional term of a range, which is zero.
  OperatingPointModel AddOrder(size_t range) const;

 private:
  std::vector<OperatingRange> ranges_;
  std::vector<int> orders_;
  ImageSize image_size_;
  std::vector<BSplineSurface> terms_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_OPERATING_POINT_MODEL_H
