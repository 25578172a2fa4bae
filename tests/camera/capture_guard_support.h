/// How a camera was calibrated, and frames as it was, for the tests of the
/// capture guard.
#ifndef RAYGRID_TEST_CAPTURE_GUARD_SUPPORT_H
#define RAYGRID_TEST_CAPTURE_GUARD_SUPPORT_H

#include <chrono>
#include <cstdint>
#include <string>

#include "frame_source.h"
#include "rg_blob.h"

namespace raygrid {

inline constexpr uint8_t kAll = 15;
inline constexpr SensorCrop kShown = {0, 0, 640, 480};
inline constexpr std::chrono::milliseconds kNoTime(0);

/// Focused to half a metre within 1/8 dpt, the part kShown, no zoom, upright.
inline rg_capture_section Recorded(uint8_t known = kAll) {
  rg_capture_section recorded = {};
  recorded.known = known;
  recorded.lens_position_q16 = 2 << 16;
  recorded.lens_tolerance_q16 = 1 << 13;
  recorded.crop_x = kShown.x;
  recorded.crop_y = kShown.y;
  recorded.crop_width = kShown.width;
  recorded.crop_height = kShown.height;
  recorded.zoom_q16 = 1 << 16;
  recorded.orientation = 1;
  return recorded;
}

inline FrameInfo AsCalibrated() {
  FrameInfo info = {};
  info.lens_position = 2;
  info.crop = kShown;
  info.zoom = 1;
  info.orientation = 1;
  return info;
}

inline bool Has(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

}  // namespace raygrid

#endif  // RAYGRID_TEST_CAPTURE_GUARD_SUPPORT_H
