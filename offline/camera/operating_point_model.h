#ifndef RAYGRID_CAMERA_OPERATING_POINT_MODEL_H
#define RAYGRID_CAMERA_OPERATING_POINT_MODEL_H

#include <optional>
#include <string>
#include <vector>

#include "camera/central_generic.h"

namespace raygrid {

/// The quantity that a camera changes with.
enum class OperatingParameter {
  kLensPosition,  ///< dioptres: 1 / metres to what is sharp
  kTemperature    ///< degrees Celsius, of the sensor
};

/// "lens_position", "temperature": as in options and files.
std::string OperatingParameterName(OperatingParameter condition);
/// "dioptres", "°C".
std::string OperatingParameterUnit(OperatingParameter condition);
/// Nothing if no condition has the name.
std::optional<OperatingParameter> FindOperatingParameter(
    const std::string& name);

/// The values of a condition from low to high, which differ.
struct OperatingRange {
  OperatingParameter condition = OperatingParameter::kLensPosition;
  double low = 0, high = 1;

  double Middle() const { return (low + high) / 2; }
  bool Contains(double value) const { return value >= low && value <= high; }
  /// So many values, from one end to the other.
  std::vector<double> Spread(int count) const;
  /// "0 to 10 dioptres".
  std::string Text() const;
};

/// A value of each condition, in the order of a stack's ranges.
using OperatingPoint = std::vector<double>;
/// The values of those conditions that are held.
using FixedOperatingPoint = std::vector<std::optional<double>>;

/// The cameras that a camera with a grid is over ranges of one condition or
/// two. Each control point is a sum of polynomials of the conditions,
///   c(v, w) = c_0 + a_1 t + a_2 t^2 + ... + b_1 u + b_2 u^2 + ...,
/// t = (v - middle) / half range, and u alike of the second condition's value
/// w. So t and u are -1 to 1 over the ranges. All grids lie over one area.
class OperatingPointModel {
 public:
  static constexpr int kMaxConditions = 2, kMaxOrder = 3;

  /// A camera that does not change, yet: orders has that of each range's
  /// polynomial.
  OperatingPointModel(std::vector<OperatingRange> ranges,
                      std::vector<int> orders, const CentralGeneric& camera);

  const std::vector<OperatingRange>& ranges() const { return ranges_; }
  const std::vector<int>& orders() const { return orders_; }
  OperatingPoint Middle() const;
  const ImageSize& image_size() const { return image_size_; }

  /// c_0, then the terms of each range in turn, from the first power on; of one
  /// shape.
  const std::vector<BSplineSurface>& terms() const { return terms_; }
  std::vector<BSplineSurface>& terms() { return terms_; }
  /// The place of a range's first power among the terms.
  int FirstTerm(size_t range) const;

  /// The factors of the terms: 1, t, t^2, ..., u, u^2, ... Values may lie
  /// outside the ranges.
  std::vector<double> EvaluateBasis(const OperatingPoint& values) const;

  /// The camera at values; outside the ranges, what the polynomials go on to.
  CentralGeneric At(const OperatingPoint& values) const;

  /// The stack over the conditions that are not held.
  OperatingPointModel Hold(const FixedOperatingPoint& at) const;
  /// The stack over one of the ranges, with the others in the middle.
  OperatingPointModel SliceAlong(size_t range) const;

  /// A stack with one term more of a range, which does not change it.
  OperatingPointModel AddOrder(size_t range) const;

 private:
  std::vector<OperatingRange> ranges_;
  std::vector<int> orders_;
  ImageSize image_size_;
  std::vector<BSplineSurface> terms_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_OPERATING_POINT_MODEL_H
