/// Checks that frames have the capture settings of the calibration.
#ifndef RAYGRID_LIBCAMERA_CAPTURE_GUARD_H
#define RAYGRID_LIBCAMERA_CAPTURE_GUARD_H

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "frame_source.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// Returns the blob's capture section, or nullopt if it has none. Throws
/// CameraError if it is corrupt or has values out of range.
std::optional<rg_capture_section> ReadCapture(const std::string& path,
                                              const void* blob,
                                              uint32_t num_bytes);

/// Returns the sensor crop of calibrated frames, or nullopt if not recorded.
std::optional<SensorCrop> RecordedCrop(
    const std::optional<rg_capture_section>& recorded);

/// Formats an EXIF orientation: "rotated by 180 degrees (3)"; "" if invalid.
std::string FormatOrientation(int orientation);

/// Returns the orientation, 1 to 8, of frames after additional mirroring.
int Mirrored(int orientation, bool flip_x, bool flip_y);

/// Mirroring of frames with one orientation relative to another one; nullopt if
/// rows and columns are exchanged, or an orientation is invalid.
struct Flips {
  bool x = false, y = false;
};
std::optional<Flips> FlipsBetween(int orientation, int other);

/// Compares lens position, crop, zoom and orientation of each frame with the
/// settings recorded at calibration, and counts frames that differ. Reports
/// each difference once, and settings missing in the metadata. A large
/// difference of the sensor temperature is reported once, but not counted.
class CaptureGuard {
 public:
  using Log = std::function<void(const std::string&)>;

  /// In strict mode, differences throw CameraError. At the start, the camera
  /// has this time, and this number of frames, to reach the calibrated
  /// settings; until then frames are held back.
  static constexpr std::chrono::seconds kSettlingTime{2};
  static constexpr uint64_t kSettlingFrames = 8;

  /// what: name of the frames' source in messages, such as "camera"; say:
  /// receives messages for the user, in the thread of Check()
  CaptureGuard(const std::optional<rg_capture_section>& recorded,
               const std::string& what, bool is_strict, Log say);

  /// Whether no settings are recorded, so that frames are not compared.
  bool is_idle() const { return !recorded_; }
  /// Sensor crop of calibrated frames; nullopt if not recorded.
  std::optional<SensorCrop> crop() const { return RecordedCrop(recorded_); }
  /// Returns the mirroring of frames relative to calibrated ones, if known.
  Flips GetFlips(const FrameInfo& info) const;

  /// Returns whether the frame is usable. Throws CameraError.
  /// in_use       sensor mode of the table; NULL: as calibrated
  /// shows_mode   whether the frame has the sensor crop of this mode
  bool Check(const FrameInfo& info, const rg_mode* in_use, bool shows_mode,
             Clock::time_point arrived);
  /// Reports recorded settings that no frame provided.
  void Finish();

  uint64_t num_not_as_calibrated() const { return num_not_as_calibrated_; }
  /// Number of frames with differences that were not used.
  uint64_t num_held_back() const { return num_held_back_; }

 private:
  enum Kind { kLens, kCrop, kZoom, kOrientation, kNumKinds };
  // Descriptions of a frame's differences by kind; "" if there is none.
  struct Faults {
    std::string of[kNumKinds];
  };

  Faults Compare(const FrameInfo& info, const rg_mode* in_use,
                 bool shows_mode) const;
  std::string DescribeLensFault(float lens_position) const;
  std::string DescribeCropFault(const SensorCrop& crop) const;
  std::string DescribeZoomFault(double zoom) const;
  std::string DescribeOrientationFault(int orientation,
                                       const rg_mode* in_use) const;
  bool IsKnown(uint8_t bit) const { return (recorded_->known & bit) != 0; }
  void RecordMetadata(const FrameInfo& info);
  void LogMissingMetadata();
  void LogTemperature(const FrameInfo& info);

  const std::optional<rg_capture_section> recorded_;
  const std::string what_;
  const bool is_strict_;
  const Log log_;
  bool was_reported_[kNumKinds] = {}, is_recorded_[kNumKinds] = {};
  bool was_complete_ = false;  // missing settings were reported
  bool was_temperature_reported_ = false;
  bool was_as_calibrated_ = false;
  uint64_t num_frames_ = 0;
  Clock::time_point first_arrived_;
  std::atomic<uint64_t> num_not_as_calibrated_{0}, num_held_back_{0};
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_CAPTURE_GUARD_H
