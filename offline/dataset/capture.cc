#include "dataset/capture.h"

#include <cmath>
#include <cstdlib>

namespace raygrid {
namespace {

// Limits of formats/SPEC.md.
constexpr double kMaxDioptres = 1024, kMaxZoom = 1024;
constexpr double kMaxTemperatureC = 1024, kMaxExposureUs = 1 << 30;
constexpr double kMinGain = 1 / 65536.0, kMaxGain = 1024;
constexpr int kMaxCrop = 65536, kMaxScale = 64;

// Whether the extent of a crop along one axis is valid for the image size.
bool IsPossible(int start, int span, int image) {
  return start >= -kMaxCrop && start <= kMaxCrop && span >= 1 &&
         span <= kMaxCrop && span <= int64_t{kMaxScale} * image &&
         image <= int64_t{kMaxScale} * span;
}

}  // namespace

const char* FindInvalidValue(const Capture& capture, const ImageSize& size) {
  const auto& crop = capture.crop;
  if (capture.lens_position &&
      !(std::abs(*capture.lens_position) <= kMaxDioptres))
    return "lens position: must be -1024 to 1024 dioptres";
  if (!(capture.lens_tolerance >= 0 && capture.lens_tolerance <= kMaxDioptres))
    return "lens tolerance: must be 0 to 1024 dioptres";
  if (crop && !(IsPossible((*crop)[0], (*crop)[2], size.width) &&
                IsPossible((*crop)[1], (*crop)[3], size.height)))
    return "crop: X, Y, width and height must be at most 65536 sensor pixels, "
           "and 1/64 to 64 times the image size";
  if (capture.zoom && !(*capture.zoom >= 1 && *capture.zoom <= kMaxZoom))
    return "zoom: must be 1 (widest) to 1024";
  if (capture.orientation &&
      !(*capture.orientation >= 1 && *capture.orientation <= 8))
    return "orientation: must be 1 to 8, as in EXIF";
  const auto is_in = [](const std::optional<double>& value, double least,
                        double most) {
    return !value || (*value >= least && *value <= most);
  };
  if (!is_in(capture.sensor_temperature_c, -kMaxTemperatureC, kMaxTemperatureC))
    return "temperature: must be -1024 to 1024 degrees Celsius";
  if (!is_in(capture.exposure_us, 1, kMaxExposureUs))
    return "exposure: must be 1 to 2^30 microseconds";
  if (!is_in(capture.analogue_gain, kMinGain, kMaxGain))
    return "gain: must be a factor of 1/65536 to 1024";
  return nullptr;
}

}  // namespace raygrid
