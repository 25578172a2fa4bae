/// Whether frames are taken as the calibrated ones were.
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

/// The blob's capture section; nothing if it has none. Throws CameraError where
/// it is damaged, or holds what no camera can be.
std::optional<rg_capture_section> ReadCapture(const std::string& path,
                                              const void* blob,
                                              uint32_t num_bytes);

/// The part of the sensor that calibrated frames show, where that is recorded.
std::optional<SensorCrop> RecordedCrop(
    const std::optional<rg_capture_section>& recorded);

/// "rotated by 180 degrees (3)"; "" for a number that is none.
std::string OrientationText(int orientation);

/// How frames of an orientation, 1 to 8, would be turned once mirrored, too.
int Mirrored(int orientation, bool flip_x, bool flip_y);

/// How frames of an orientation are mirrored against those of another one;
/// nothing where rows are columns of the other, or a number is none.
struct Flips {
  bool x = false, y = false;
};
std::optional<Flips> FlipsBetween(int orientation, int other);

/// Compares lens position, crop, zoom and orientation of each frame with those
/// that calibration recorded. Says once what is not as then, and what cannot
/// be compared since the source does not tell it. Counts such frames. A sensor
/// that is much warmer or colder than then is said once, and counts for
/// nothing.
class CaptureGuard {
 public:
  using Say = std::function<void(const std::string&)>;

  /// Strict: throws instead. A camera that has not been as calibrated yet has
  /// so long, and so many frames, to get there, which are held back.
  static constexpr std::chrono::seconds kSettlingTime{2};
  static constexpr uint64_t kSettlingFrames = 8;

  /// what  tells frames, in messages: "camera"
  /// say   is called with a line for people, by the thread of Check()
  CaptureGuard(const std::optional<rg_capture_section>& recorded,
               const std::string& what, bool is_strict, Say say);

  /// Nothing is recorded: frames are not compared.
  bool is_idle() const { return !recorded_; }
  /// The part of the sensor that calibrated frames show, if that is recorded.
  std::optional<SensorCrop> crop() const { return RecordedCrop(recorded_); }
  /// How frames are mirrored against calibrated ones, as far as that is known.
  Flips FlipsOf(const FrameInfo& info) const;

  /// Whether the frame may be used. Throws CameraError.
  /// in_use        the mode of frames that the table takes; NULL: as calibrated
  /// shows_mode    whether it shows the part of the sensor that this mode does
  bool Check(const FrameInfo& info, const rg_mode* in_use, bool shows_mode,
             Clock::time_point arrived);
  /// Says what was never told by the frames that came.
  void Finish();

  uint64_t num_not_as_calibrated() const { return num_not_as_calibrated_; }
  /// Those among them that were not used.
  uint64_t num_held_back() const { return num_held_back_; }

 private:
  enum Kind { kLens, kCrop, kZoom, kOrientation, kNumKinds };
  // Texts of what is wrong with a frame, for each kind; "" where nothing is.
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
  bool was_told_all_ = false;  // what is not told was said
  bool was_temperature_said_ = false;
  bool was_as_calibrated_ = false;
  uint64_t num_frames_ = 0;
  Clock::time_point first_arrived_;
  std::atomic<uint64_t> num_not_as_calibrated_{0}, num_held_back_{0};
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_CAPTURE_GUARD_H
