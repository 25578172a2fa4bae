/// Whether a blob is for the frames that come.
#ifndef RAYGRID_LIBCAMERA_STREAM_GUARD_H
#define RAYGRID_LIBCAMERA_STREAM_GUARD_H

#include <optional>
#include <string>

#include "frame_source.h"
#include "raygrid.h"

namespace raygrid {

/// The mode of frames of width x height that show the part crop of the sensor,
/// where the camera's own frames showed the part calibrated.
std::optional<rg_mode> FindSensorMode(const rg_camera& camera,
                                      const SensorCrop& calibrated,
                                      const SensorCrop& crop, uint16_t width,
                                      uint16_t height);

/// Frames are as calibrated when they have the blob's size and show the part of
/// the sensor that the calibration's did; where that is not known, what the
/// first one showed. Derivable ones are good for positions only.
class StreamGuard {
 public:
  enum class Use { kFrames, kPositions };

  /// serial  of the camera; empty: not known
  StreamGuard(const rg_camera& camera, const StreamFormat& format, Use use,
              const std::string& serial,
              const std::optional<SensorCrop>& calibrated);

  /// Throws CameraError where the blob is not for such a frame.
  void Check(const FrameInfo& info);

  /// How the last frame lay in calibrated ones; nothing: as they are.
  const std::optional<rg_mode>& mode() const { return mode_; }

 private:
  const char* serial() const;  // NULL: not known
  std::string Explain() const;

  const rg_camera& camera_;
  const StreamFormat format_;
  const Use use_;
  const std::string serial_;
  std::optional<SensorCrop> calibrated_, last_;
  bool is_good_ = false;
  std::optional<rg_mode> mode_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STREAM_GUARD_H
