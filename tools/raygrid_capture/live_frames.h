/// Frames to detect boards in, from a camera, a video, or a folder.
#ifndef RAYGRID_CAPTURE_LIVE_FRAMES_H
#define RAYGRID_CAPTURE_LIVE_FRAMES_H

#include <memory>
#include <optional>
#include <string>

#include "dataset/image_files.h"
#include "features/board_view/detection.h"
#include "frame_source.h"

namespace raygrid {

/// A grey image with its metadata.
struct LiveFrame {
  Image image;                   ///< 8 or 16 bits
  GreyImage grey;                ///< image converted for detectors
  std::string name;              ///< file name of a photograph; else empty
  std::string path;              ///< path of a photograph; else empty
  std::optional<double> time_s;  ///< since the first; nullopt: photograph
  FrameInfo info = {};
  Clock::time_point arrived = {};  ///< arrival from a camera
};

class LiveFrames {
 public:
  virtual ~LiveFrames() = default;
  /// Returns the next frame; nullopt if none arrives soon. Throws InputError,
  /// CameraError.
  virtual std::optional<LiveFrame> Next() = 0;
  virtual bool is_finished() const = 0;
  /// Whether frames arrive at a fixed rate, so that slow processing drops some.
  virtual bool is_live() const = 0;
  /// Returns the fraction of all frames that were returned, 0 to 1; nullopt if
  /// unknown.
  virtual std::optional<double> done() const { return std::nullopt; }
  /// Returns the camera; NULL for files.
  virtual FrameSource* source() { return nullptr; }
};

/// Reads the photographs of a folder, ordered by name. Unreadable ones, and
/// those of another size than the first, are listed on standard error.
std::unique_ptr<LiveFrames> MakeFolderFrames(const std::string& folder);

/// Reads frames of a camera or a pipe. Throws CameraError for a format without
/// a grey level per pixel, such as Bayer.
std::unique_ptr<LiveFrames> MakeSourceFrames(
    std::unique_ptr<FrameSource> source, bool is_live);

/// Reads frames of a video: Y4M and motion JPEG directly, other formats through
/// ffmpeg. Throws InputError.
std::unique_ptr<LiveFrames> MakeVideoFrames(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_LIVE_FRAMES_H
