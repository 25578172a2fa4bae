/// Checks whether a blob matches the frames of a stream.
#ifndef RAYGRID_LIBCAMERA_STREAM_GUARD_H
#define RAYGRID_LIBCAMERA_STREAM_GUARD_H

#include <optional>
#include <string>

#include "capture_guard.h"
#include "frame_source.h"
#include "raygrid.h"

namespace raygrid {

/// Returns the sensor mode of frames of width x height with a sensor crop;
/// calibrated: crop of the calibrated frames; flips: relative to these frames.
std::optional<rg_mode> FindSensorMode(const rg_camera& camera,
                                      const SensorCrop& calibrated,
                                      const SensorCrop& crop, uint16_t width,
                                      uint16_t height, const Flips& flips = {});

/// Returns the blob's table for frames of a format with a sensor crop, or
/// RG_NO_TABLE. calibrated: crop of the calibrated frames; if it is unknown,
/// frames of equal size are assumed to have the same crop.
uint32_t FindTable(const rg_camera& camera, const StreamFormat& format,
                   const std::optional<SensorCrop>& calibrated,
                   const std::optional<SensorCrop>& shown,
                   const Flips& flips = {});

/// Explains why rg_select_remap() rejects a table, with the remedy: "has no
/// remap table 7, only 0 to 2; choose one of these".
std::string DescribeTableFault(const rg_camera& camera, uint32_t table);

/// Whether the blob has tables for other sensor modes.
bool HasTablesOfModes(const rg_camera& camera);

/// Checks that frames have the size and sensor crop of the selected table. If
/// the crop at calibration is unknown, all frames must have the first frame's
/// crop. For points, frames of other sensor modes may be usable by conversion.
/// If the blob records the crop, a CaptureGuard handles other crops.
class StreamGuard {
 public:
  enum class Use { kFrames, kPositions };

  /// serial: the camera's serial number; empty: unknown. calibrated: overrides
  /// the crop recorded in the blob. capture: compares frames with the recorded
  /// settings; NULL: no comparison.
  StreamGuard(const rg_camera& camera, const StreamFormat& format, Use use,
              const std::string& serial,
              const std::optional<SensorCrop>& calibrated,
              CaptureGuard* capture = nullptr);

  /// Throws CameraError if the blob does not match the format, without a frame.
  void CheckFormat() { IsShownAsInUse({}); }
  /// Whether the frame is usable. Throws CameraError if the blob does not fit.
  bool Check(const FrameInfo& info, Clock::time_point arrived = Clock::now());
  /// Number of frames that were held back.
  uint64_t num_held_back() const {
    return capture_ ? capture_->num_held_back() : 0;
  }

  /// Sensor mode of the last frame; nullopt: as calibrated.
  const std::optional<rg_mode>& mode() const { return mode_; }

 private:
  const char* serial() const;  // NULL: unknown
  bool HasSerial() const;
  bool MatchesTableSize() const;
  bool IsSupported() const;
  bool IsTolerated() const;
  bool IsShownAsInUse(const FrameInfo& info);
  std::string DescribeFault() const;

  const rg_camera& camera_;
  const StreamFormat format_;
  const Use use_;
  const std::string serial_;
  CaptureGuard* const capture_;
  const bool is_recorded_;  // whether the user specified the calibrated crop
  std::optional<SensorCrop> calibrated_, first_, last_;
  std::optional<int> last_orientation_;
  bool is_known_ = false, is_supported_ = false;  // for the last frame
  std::optional<rg_mode> mode_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STREAM_GUARD_H
