#ifndef RAYGRID_DATASET_CAPTURE_H
#define RAYGRID_DATASET_CAPTURE_H

#include <array>
#include <optional>

#include "camera/camera_model.h"

namespace raygrid {

/// Frames whose lens is so many dioptres away are taken for calibrated ones:
/// the image of a lens of 4 mm grows by 0.04 % then, 0.4 px at 1000 px from the
/// middle.
constexpr double kDefaultLensTolerance = 0.1;

/// How the camera stood while it was calibrated, as the source of its frames
/// told it.
struct Capture {
  std::optional<double> lens_position;  ///< dioptres
  double lens_tolerance = kDefaultLensTolerance;
  /// The part of the sensor that frames show: x, y, width, height in its
  /// pixels.
  std::optional<std::array<int, 4>> crop;
  std::optional<double> zoom;      ///< magnification over the widest
  std::optional<int> orientation;  ///< 1 to 8, as EXIF and libcamera have it
  std::optional<double> sensor_temperature_c;  ///< degrees Celsius
  std::optional<double> exposure_us;           ///< microseconds
  std::optional<double> analogue_gain;         ///< a factor

  bool KnowsAny() const {
    return lens_position || crop || zoom || orientation ||
           sensor_temperature_c || exposure_us || analogue_gain;
  }
};

/// The name of a value that no camera with images of that size has, and which
/// ones are possible; NULL if all are.
const char* FindImpossible(const Capture& capture, const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CAPTURE_H
