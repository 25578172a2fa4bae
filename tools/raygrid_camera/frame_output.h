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
  /// Throws CameraError; nothing half-written stays.
  ///
  /// number  of the frame, as FrameNumbers has it
  virtual void Write(const UndistortedFrame& frame, uint64_t number) = 0;
};

/// FOLDER/frame-000000.raw and so on: a text header that ends with a line
/// "...", and the planes.
std::unique_ptr<FrameOutput> MakeRawFiles(const std::string& folder,
                                          const StreamFormat& format);

/// FOLDER/frame-000000.png and so on, 8 bits a channel.
std::unique_ptr<FrameOutput> MakePngFiles(const std::string& folder,
                                          const StreamFormat& format);

/// Planes to a pipe, frame after frame. When is_stopped says so, a reader that
/// takes nothing is waited for a second more.
std::unique_ptr<FrameOutput> MakePipe(int fd, std::function<bool()> is_stopped);

/// The commands that play the pipe.
std::string DescribePipe(const StreamFormat& format, double frames_per_second);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_OUTPUT_H
