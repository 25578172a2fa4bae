/// Frames to look for boards in: of a camera, a video, or a folder.
#ifndef RAYGRID_CAPTURE_LIVE_FRAMES_H
#define RAYGRID_CAPTURE_LIVE_FRAMES_H

#include <memory>
#include <optional>
#include <string>

#include "dataset/image_files.h"
#include "features/board_view/detection.h"
#include "frame_source.h"

namespace raygrid {

/// A frame in shades of grey.
struct LiveFrame {
  Image image;                   ///< 8 or 16 bits
  GreyImage grey;                ///< the same, for detectors
  std::string name;              ///< of a photograph's file; else empty
  std::string path;              ///< likewise
  std::optional<double> time_s;  ///< since the first; none: a photograph
  FrameInfo info = {};
  Clock::time_point arrived = {};  ///< of cameras
};

class LiveFrames {
 public:
  virtual ~LiveFrames() = default;
  /// The next frame; nothing when none comes soon. Throws InputError,
  /// CameraError.
  virtual std::optional<LiveFrame> Next() = 0;
  virtual bool is_finished() const = 0;
  /// Frames come whether they are taken or not: who is slow misses some.
  virtual bool is_live() const = 0;
  /// The part of all frames that were taken, 0 to 1; nothing where nobody
  /// knows.
  virtual std::optional<double> done() const { return std::nullopt; }
  /// The camera behind; NULL for files.
  virtual FrameSource* source() { return nullptr; }
};

/// The photographs of a folder, in the order of their names. Those that cannot
/// be read, or have another size than the first, are named on standard error.
std::unique_ptr<LiveFrames> MakeFolderFrames(const std::string& folder);

/// The frames of a camera or a pipe. Throws CameraError: a format that holds no
/// plain grey, such as Bayer's.
std::unique_ptr<LiveFrames> MakeSourceFrames(
    std::unique_ptr<FrameSource> source, bool is_live);

/// The frames of a video: Y4M and motion JPEG are read as they are, others by
/// the program ffmpeg. Throws InputError.
std::unique_ptr<LiveFrames> MakeVideoFrames(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_LIVE_FRAMES_H
