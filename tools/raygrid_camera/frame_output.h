/// The outputs of undistorted frames.
#ifndef RAYGRID_CAMERA_FRAME_OUTPUT_H
#define RAYGRID_CAMERA_FRAME_OUTPUT_H

#include <functional>
#include <memory>
#include <string>

#include "undistorter.h"

namespace raygrid {

class FrameOutput {
 public:
  virtual ~FrameOutput() = default;
  /// Writes a frame. Throws CameraError, and leaves no incomplete file.
  ///
  /// number  of the frame, from FrameNumbers
  virtual void Write(const UndistortedFrame& frame, uint64_t number) = 0;
};

/// Writes FOLDER/frame-000000.raw and so on: a text header, which
/// ends with a line "...", and the planes.
std::unique_ptr<FrameOutput> MakeRawFiles(const std::string& folder,
                                          const StreamFormat& format);

/// Writes FOLDER/frame-000000.png and so on, 8 bits per channel.
std::unique_ptr<FrameOutput> MakePngFiles(const std::string& folder,
                                          const StreamFormat& format);

/// Writes the planes of all frames to a pipe. Once is_stopped() returns true, a
/// stalled reader is waited for one more second.
std::unique_ptr<FrameOutput> MakePipe(int fd, std::function<bool()> is_stopped);

/// Describes commands that play the pipe.
std::string DescribePipe(const StreamFormat& format, double frames_per_second);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_OUTPUT_H
