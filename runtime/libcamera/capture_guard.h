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

/// Reads the blob's capture section; nothing if it has none. Throws CameraError
/// if it is corrupt, or has impossible values.
std::optional<rg_capture_section> ReadCapture(const std::string& path,
                                              const void* blob,
                                              uint32_t num_bytes);

/// The sensor crop of calibrated frames, if it is recorded.
std::optional<SensorCrop> RecordedCrop(
    const std::optional<rg_capture_section>& recorded);

/// "rotated by 180 degrees (3)"; "" for an invalid number.
std::string OrientationText(int orientation);

/// The orientation, 1 to 8, of frames after additional mirroring.
int Mirrored(int orientation, bool flip_x, bool flip_y);

/// How frames of one orientation are mirrored relative to another one; nothing
/// if rows and columns are exchanged, or a number is invalid.
struct Flips {
  bool x = false, y = false;
};
std::optional<Flips> FlipsBetween(int orientation, int other);

/// Compares lens position, crop, zoom and orientation of each frame with those
/// recorded at calibration. Reports each difference once, and settings that the
/// source does not provide. Counts such frames. A large difference of the
/// sensor temperature is reported once, but not counted.
class CaptureGuard {
 public:
  using Say = std::function<void(const std::string&)>;

  /// In strict mode, throws instead. A camera without the calibrated settings
  /// has this time, and this number of frames, to reach them; these frames are
  /// held back.
  static constexpr std::chrono::seconds kSettlingTime{2};
  static constexpr uint64_t kSettlingFrames = 8;

  /// what: the name of frames in messages: "camera"; say: called with a message
  /// for the user, by the thread of Check()
  CaptureGuard(const std::optional<rg_capture_section>& recorded,
               const std::string& what, bool is_strict, Say say);

  /// Whether nothing is recorded: frames are not compared.
  bool is_idle() const { return !recorded_; }
  /// The sensor crop of calibrated frames, if it is recorded.
  std::optional<SensorCrop> crop() const { return RecordedCrop(recorded_); }
  /// How frames are mirrored relative to calibrated ones, if known.
  Flips FlipsOf(const FrameInfo& info) const;

  /// Whether the frame is usable. Throws CameraError.
  /// in_use       the sensor mode of the table; NULL: as calibrated
  /// shows_mode   whether the frame shows the sensor crop of this mode
  bool Check(const FrameInfo& info, const rg_mode* in_use, bool shows_mode,
             Clock::time_point arrived);
  /// Reports settings that no frame provided.
  void Finish();

  uint64_t num_not_as_calibrated() const { return num_not_as_calibrated_; }
  /// The number of those that were not used.
  uint64_t num_held_back() const { return num_held_back_; }

 private:
  enum Kind { kLens, kCrop, kZoom, kOrientation, kNumKinds };
  // Descriptions of a frame's differences, by kind; "" if there is none.
  struct Faults {
    std::string of[kNumKinds];
  };

  Faults Compare(const FrameInfo& info, const rg_mode* in_use,
                 bool shows_mode) const;
  std::string FaultOfLens(float lens_position) const;
  std::string FaultOfCrop(const SensorCrop& crop) const;
  std::string FaultOfZoom(double zoom) const;
  std::string FaultOfOrientation(int orientation, const rg_mode* in_use) const;
  bool IsKnown(uint8_t bit) const { return (recorded_->known & bit) != 0; }
  void NoteTold(const FrameInfo& info);
  void SayWhatIsNotTold();
  void SayTemperature(const FrameInfo& info);

  const std::optional<rg_capture_section> recorded_;
  const std::string what_;
  const bool is_strict_;
  const Say say_;
  bool was_said_[kNumKinds] = {}, is_told_[kNumKinds] = {};
  bool was_told_all_ = false;  // missing settings were reported
  bool was_temperature_said_ = false;
  bool was_as_calibrated_ = false;
  uint64_t num_frames_ = 0;
  Clock::time_point first_arrived_;
  std::atomic<uint64_t> num_not_as_calibrated_{0}, num_held_back_{0};
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_CAPTURE_GUARD_H
