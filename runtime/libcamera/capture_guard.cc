#include "capture_guard.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <utility>

#include "camera_error.h"

namespace raygrid {
namespace {

constexpr double kQ16 = 65536;
// A zoom of 1 + this displaces a point 1000 px from the centre by half a pixel.
constexpr double kZoomTolerance = 0.0005;
// Cameras may report a lens position some frames late.
constexpr uint64_t kMaxFramesWithoutMetadata = 10;

[[gnu::format(printf, 1, 2)]] std::string Print(const char* format, ...) {
  char text[512];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof(text), format, values);
  va_end(values);
  return text;
}

std::string FormatCrop(const SensorCrop& crop) {
  return Print("%d,%d,%ux%u", crop.x, crop.y, crop.width, crop.height);
}

// By EXIF orientation: a flip along x (bit 0), a flip along y (bit 1) and a
// transposition (bit 2), applied in this order.
constexpr int kTurnOfOrientation[] = {0, 0, 1, 3, 2, 4, 5, 7, 6};

int OrientationOfTurn(int turn) {
  for (int orientation = 1; orientation <= 8; ++orientation)
    if (kTurnOfOrientation[orientation] == turn) return orientation;
  return 0;
}

bool IsOrientation(int orientation) {
  return orientation >= 1 && orientation <= 8;
}

}  // namespace

std::optional<rg_capture_section> ReadCapture(const std::string& path,
                                              const void* blob,
                                              uint32_t num_bytes) {
  if (!rg_find_section(static_cast<const uint8_t*>(blob), RG_SECTION_CAPTURE,
                       0))
    return std::nullopt;
  rg_blob whole;
  const rg_status status = rg_blob_open(blob, num_bytes, &whole);
  if (status != RG_OK)
    throw CameraError(CameraExit::kBlob, path + ": " + rg_status_text(status) +
                                             "; pack or copy the blob again");
  rg_capture_section section;
  rg_blob_capture(&whole, &section);
  return section;
}

std::optional<SensorCrop> RecordedCrop(
    const std::optional<rg_capture_section>& recorded) {
  if (!recorded || !(recorded->known & RG_CAPTURE_HAS_CROP))
    return std::nullopt;
  return SensorCrop{recorded->crop_x, recorded->crop_y, recorded->crop_width,
                    recorded->crop_height};
}

std::string FormatOrientation(int orientation) {
  static const char* const kTexts[] = {"upright",
                                       "mirrored",
                                       "rotated by 180 degrees",
                                       "upside down and mirrored",
                                       "rotated by 90 degrees and mirrored",
                                       "rotated by 270 degrees",
                                       "rotated by 270 degrees and mirrored",
                                       "rotated by 90 degrees"};
  if (!IsOrientation(orientation)) return "";
  return Print("%s (%d)", kTexts[orientation - 1], orientation);
}

int Mirrored(int orientation, bool flip_x, bool flip_y) {
  if (!IsOrientation(orientation)) return 0;
  const int turn = kTurnOfOrientation[orientation];
  // After a transposition, the axes are exchanged.
  if (turn & 4) std::swap(flip_x, flip_y);
  return OrientationOfTurn(turn ^ (flip_x ? 1 : 0) ^ (flip_y ? 2 : 0));
}

std::optional<Flips> FlipsBetween(int orientation, int other) {
  if (!IsOrientation(other)) return std::nullopt;
  for (int bits = 0; bits < 4; ++bits)
    if (Mirrored(orientation, bits & 1, bits & 2) == other)
      return Flips{(bits & 1) != 0, (bits & 2) != 0};
  return std::nullopt;
}

CaptureGuard::CaptureGuard(const std::optional<rg_capture_section>& recorded,
                           const std::string& what, bool is_strict, Log say)
    : recorded_(recorded),
      what_(what),
      is_strict_(is_strict),
      log_(std::move(say)) {}

std::string CaptureGuard::DescribeLensFault(float lens_position) const {
  const double value_q16 = std::round(double{lens_position} * kQ16);
  if (std::abs(value_q16 - recorded_->lens_position_q16) <=
      recorded_->lens_tolerance_q16)
    return "";
  const double recorded = recorded_->lens_position_q16 / kQ16;
  return Print(
      "lens position is %.6g dpt, calibrated at %.6g +- %.6g; restore it with "
      "--control AfMode=Manual --control LensPosition=%.6g, or calibrate at "
      "the current one",
      double{lens_position}, recorded, recorded_->lens_tolerance_q16 / kQ16,
      recorded);
}

std::string CaptureGuard::DescribeCropFault(const SensorCrop& crop) const {
  const SensorCrop recorded = *RecordedCrop(recorded_);
  const std::string zoom =
      crop.width == 0
          ? ""
          : Print(", zoom %.4g", double{1} * recorded.width / crop.width);
  return "frames have crop " + FormatCrop(crop) + ", calibrated with crop " +
         FormatCrop(recorded) + zoom +
         "; select the matching mode, --table or --control ScalerCrop, or add "
         "a table for this mode with raygrid pack --mode";
}

std::string CaptureGuard::DescribeZoomFault(double zoom) const {
  const double recorded = recorded_->zoom_q16 / kQ16;
  if (std::abs(zoom / recorded - 1) <= kZoomTolerance) return "";
  return Print(
      "zoom is %.6g, calibrated at %.6g; restore it, for V4L2 with --control "
      "zoom_absolute, or calibrate at the current zoom",
      zoom, recorded);
}

std::string CaptureGuard::DescribeOrientationFault(
    int orientation, const rg_mode* in_use) const {
  const int expected =
      Mirrored(recorded_->orientation, in_use && in_use->flip_x != 0,
               in_use && in_use->flip_y != 0);
  if (orientation == expected) return "";
  return "frames are " + FormatOrientation(orientation) + ", but " +
         (expected == recorded_->orientation ? "calibration"
                                             : "the table's sensor mode") +
         " had " + FormatOrientation(expected) +
         "; restore the camera's flips, or add a table for this mode with "
         "raygrid pack --mode NAME:flip=h";
}

CaptureGuard::Faults CaptureGuard::Compare(const FrameInfo& info,
                                           const rg_mode* in_use,
                                           bool shows_mode) const {
  Faults faults;
  if (IsKnown(RG_CAPTURE_HAS_LENS_POSITION) && is_recorded_[kLens] &&
      info.lens_position)
    faults.of[kLens] = DescribeLensFault(*info.lens_position);
  if (IsKnown(RG_CAPTURE_HAS_CROP) && info.crop) {
    if (!shows_mode) faults.of[kCrop] = DescribeCropFault(*info.crop);
  } else if (IsKnown(RG_CAPTURE_HAS_ZOOM) && info.zoom) {
    faults.of[kZoom] = DescribeZoomFault(*info.zoom);
  }
  if (IsKnown(RG_CAPTURE_HAS_ORIENTATION) && info.orientation)
    faults.of[kOrientation] =
        DescribeOrientationFault(*info.orientation, in_use);
  return faults;
}

Flips CaptureGuard::GetFlips(const FrameInfo& info) const {
  if (is_idle() || !IsKnown(RG_CAPTURE_HAS_ORIENTATION) || !info.orientation)
    return {};
  return FlipsBetween(recorded_->orientation, *info.orientation)
      .value_or(Flips());
}

void CaptureGuard::RecordMetadata(const FrameInfo& info) {
  is_recorded_[kLens] |= info.lens_position && !std::isnan(*info.lens_position);
  is_recorded_[kCrop] |= info.crop.has_value();
  is_recorded_[kZoom] |= info.zoom.has_value();
  is_recorded_[kOrientation] |= info.orientation.has_value();
}

void CaptureGuard::LogMissingMetadata() {
  if (was_complete_) return;
  was_complete_ = true;
  std::string missing_settings;
  const auto add = [&missing_settings](const char* text) {
    missing_settings +=
        (missing_settings.empty() ? "" : ", ") + std::string(text);
  };
  if (IsKnown(RG_CAPTURE_HAS_LENS_POSITION) && !is_recorded_[kLens])
    add("lens position");
  if (IsKnown(RG_CAPTURE_HAS_CROP) && !is_recorded_[kCrop]) add("crop");
  // A crop is more specific than a zoom.
  if (IsKnown(RG_CAPTURE_HAS_ZOOM) && !is_recorded_[kZoom] &&
      !(IsKnown(RG_CAPTURE_HAS_CROP) && is_recorded_[kCrop]))
    add("zoom");
  if (IsKnown(RG_CAPTURE_HAS_ORIENTATION) && !is_recorded_[kOrientation])
    add("orientation");
  if (!missing_settings.empty())
    log_("cannot verify the capture settings: " + what_ + " does not report " +
         missing_settings +
         "; check manually, or omit it from raygrid pack --capture-settings");
}

// A camera that warms up moves its lens, by a camera-specific amount.
void CaptureGuard::LogTemperature(const FrameInfo& info) {
  constexpr double kOtherC = 20;
  if (was_temperature_reported_ || !IsKnown(RG_CAPTURE_HAS_TEMPERATURE) ||
      !info.sensor_temperature_c)
    return;
  const double now_c = *info.sensor_temperature_c;
  const double then_c = recorded_->temperature_q16 / 65536.0;
  if (!(std::abs(now_c - then_c) > kOtherC)) return;
  was_temperature_reported_ = true;
  char text[120];
  std::snprintf(text, sizeof(text),
                "sensor temperature is %.0f °C, calibrated at %.0f °C; "
                "calibrate at the temperature of use",
                now_c, then_c);
  log_(text);
}

bool CaptureGuard::Check(const FrameInfo& info, const rg_mode* in_use,
                         bool shows_mode, Clock::time_point arrived) {
  if (is_idle()) return true;
  if (num_frames_++ == 0) first_arrived_ = arrived;
  RecordMetadata(info);
  LogTemperature(info);
  if (num_frames_ == kMaxFramesWithoutMetadata) LogMissingMetadata();
  const Faults faults = Compare(info, in_use, shows_mode);
  const std::string* first = nullptr;
  for (const std::string& fault : faults.of)
    if (!first && !fault.empty()) first = &fault;
  if (!first) {
    was_as_calibrated_ = true;
    return true;
  }
  ++num_not_as_calibrated_;
  if (is_strict_) {
    if (was_as_calibrated_ || (num_frames_ > kSettlingFrames &&
                               arrived - first_arrived_ >= kSettlingTime))
      throw CameraError(
          CameraExit::kBlob,
          "--strict: capture settings differ from calibration: " + *first);
    ++num_held_back_;
    return false;
  }
  for (int kind = 0; kind < kNumKinds; ++kind) {
    if (faults.of[kind].empty() || was_reported_[kind]) continue;
    was_reported_[kind] = true;
    log_("capture settings differ from calibration: " + faults.of[kind]);
  }
  return true;
}

void CaptureGuard::Finish() {
  if (!is_idle() && num_frames_ > 0) LogMissingMetadata();
}

}  // namespace raygrid
