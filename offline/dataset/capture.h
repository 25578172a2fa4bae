#ifndef RAYGRID_DATASET_CAPTURE_H
#define RAYGRID_DATASET_CAPTURE_H

#include <array>
#include <optional>

#include "camera/camera_model.h"

namespace raygrid {

/// Tolerance of the lens position in dioptres: frames within it count as
/// calibrated. The image of a 4 mm lens then changes by 0.04 %, 0.4 px at 1000
/// px from the centre.
constexpr double kDefaultLensTolerance = 0.1;

/// The capture settings at calibration, from the metadata of its frames.
struct Capture {
  std::optional<double> lens_position;  ///< dioptres
  double lens_tolerance = kDefaultLensTolerance;
  /// The sensor crop: x, y, width, height in sensor pixels.
  std::optional<std::array<int, 4>> crop;
  std::optional<double> zoom;      ///< relative to the widest setting
  std::optional<int> orientation;  ///< 1 to 8, as in EXIF and libcamera
  std::optional<double> sensor_temperature_c;  ///< degrees Celsius
  std::optional<double> exposure_us;           ///< microseconds
  std::optional<double> analogue_gain;         ///< as a factor

  bool HasAny() const {
    return lens_position || crop || zoom || orientation ||
           sensor_temperature_c || exposure_us || analogue_gain;
  }
};

/// Returns the name of a value that is impossible for images of that size, with
/// the valid range; NULL if all are valid.
const char* FindInvalidValue(const Capture& capture, const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CAPTURE_H
