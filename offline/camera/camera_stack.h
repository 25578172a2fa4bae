#ifndef RAYGRID_CAMERA_CAMERA_STACK_H
#define RAYGRID_CAMERA_CAMERA_STACK_H

#include <string>
#include <vector>

#include "camera/central_generic.h"

namespace raygrid {

/// The quantity that a camera changes with.
enum class CameraCondition {
  kLensPosition,  ///< dioptres: 1 / metres to what is sharp
  kTemperature    ///< degrees Celsius, of the sensor
};

/// "lens_position", "temperature": as in options and files.
std::string ConditionName(CameraCondition condition);
/// "dioptres", "°C".
std::string ConditionUnit(CameraCondition condition);

/// The cameras that a camera with a grid is over a range of a condition. Each
/// control point is a polynomial of the condition,
///   c(v) = c_0 + c_1 t + c_2 t^2 + ...,  t = (v - middle) / half range,
/// so t is -1 to 1 over the range. All grids lie over one area.
class CameraStack {
 public:
  static constexpr int kMaxOrder = 3;

  /// terms: c_0, c_1, ..., of one shape; low < high.
  CameraStack(CameraCondition condition, double low, double high,
              const ImageSize& image_size, std::vector<BSplineSurface> terms);
  /// A camera that does not change, yet.
  CameraStack(CameraCondition condition, double low, double high,
              const CentralGeneric& camera, int order);

  CameraCondition condition() const { return condition_; }
  double low() const { return low_; }
  double high() const { return high_; }
  double middle() const { return (low_ + high_) / 2; }
  bool Contains(double value) const { return value >= low_ && value <= high_; }
  int order() const { return static_cast<int>(terms_.size()) - 1; }

  const ImageSize& image_size() const { return image_size_; }
  const std::vector<BSplineSurface>& terms() const { return terms_; }
  std::vector<BSplineSurface>& terms() { return terms_; }

  /// 1, t, t^2, ... of a value, which may lie outside the range.
  std::vector<double> Powers(double value) const;

  /// The camera at a value; outside the range, what the polynomials go on to.
  CentralGeneric At(double value) const;

 private:
  CameraCondition condition_;
  double low_, high_;
  ImageSize image_size_;
  std::vector<BSplineSurface> terms_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_STACK_H
