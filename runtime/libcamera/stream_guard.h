/// Whether a blob is for the frames that come.
#ifndef RAYGRID_LIBCAMERA_STREAM_GUARD_H
#define RAYGRID_LIBCAMERA_STREAM_GUARD_H

#include <optional>
#include <string>

#include "capture_guard.h"
#include "frame_source.h"
#include "raygrid.h"

namespace raygrid {

/// The mode of frames of width x height that show the part crop of the sensor,
/// where the camera's own frames showed the part calibrated. flips: against
/// these.
std::optional<rg_mode> FindSensorMode(const rg_camera& camera,
                                      const SensorCrop& calibrated,
                                      const SensorCrop& crop, uint16_t width,
                                      uint16_t height, const Flips& flips = {});

/// The blob's table for frames of a format that show a part of the sensor, or
/// RG_NO_TABLE. calibrated: the part that the camera's own frames showed; where
/// that is not known, frames of their size are taken for them.
uint32_t FindTable(const rg_camera& camera, const StreamFormat& format,
                   const std::optional<SensorCrop>& calibrated,
                   const std::optional<SensorCrop>& shown,
                   const Flips& flips = {});

/// Why rg_select_remap() refuses a table, and what to do: "has no remap table
/// 7, only 0 to 2; choose one of these".
std::string DescribeTableFault(const rg_camera& camera, uint32_t table);

/// Whether a table of the blob is for another sensor mode.
bool HasTablesOfModes(const rg_camera& camera);

/// Frames are good when they have the size that the table in use takes, and
/// show the part of the sensor that its mode does. Where what the calibration's
/// frames showed is not known, all must show what the first one did. Of others,
/// positions may be good. Where the blob records what they showed, a
/// CaptureGuard says what is to come of frames that show another part.
class StreamGuard {
 public:
  enum class Use { kFrames, kPositions };

  /// serial      of the camera; empty: not known
  /// calibrated  what is told instead of what the blob records
  /// capture     compares frames with what the blob records; NULL: nothing does
  StreamGuard(const rg_camera& camera, const StreamFormat& format, Use use,
              const std::string& serial,
              const std::optional<SensorCrop>& calibrated,
              CaptureGuard* capture = nullptr);

  /// Throws CameraError where the blob is not for such frames, before one came.
  void CheckFormat() { IsShownAsInUse({}); }
  /// Whether the frame may be used. Throws CameraError where the blob is not
  /// for it.
  bool Check(const FrameInfo& info, Clock::time_point arrived = Clock::now());
  /// How many frames were held back.
  uint64_t num_held_back() const {
    return capture_ ? capture_->num_held_back() : 0;
  }

  /// How the last frame lay in calibrated ones; nothing: as they are.
  const std::optional<rg_mode>& mode() const { return mode_; }

 private:
  const char* serial() const;  // NULL: not known
  bool HasSerial() const;
  bool HasSizeOfTable() const;
  bool IsServed() const;
  bool IsBorne() const;
  bool IsShownAsInUse(const FrameInfo& info);
  std::string Explain() const;

  const rg_camera& camera_;
  const StreamFormat format_;
  const Use use_;
  const std::string serial_;
  CaptureGuard* const capture_;
  const bool is_told_;  // what was calibrated, by who started the program
  std::optional<SensorCrop> calibrated_, first_, last_;
  std::optional<int> last_orientation_;
  bool is_known_ = false, is_served_ = false;  // of the last frame
  std::optional<rg_mode> mode_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STREAM_GUARD_H
