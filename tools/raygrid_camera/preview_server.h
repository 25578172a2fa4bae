/// A page with the frames before and after, as motion JPEG over HTTP.
#ifndef RAYGRID_CAMERA_PREVIEW_SERVER_H
#define RAYGRID_CAMERA_PREVIEW_SERVER_H

#include <cstdint>
#include <memory>
#include <string>

#include "undistorter.h"

namespace raygrid {

/// Serves "/", "/before" and "/after", nothing else. Encodes only while someone
/// looks, on a thread of its own; who is slow sees fewer frames. No client can
/// make it keep more than a few kilobytes and one picture, and there are at
/// most 16.
class PreviewServer : public FrameObserver {
 public:
  /// address  numerical; "127.0.0.1" is this machine only
  /// Throws CameraError where the port is taken.
  PreviewServer(const std::string& address, uint16_t port,
                const StreamFormat& before, const StreamFormat& after);
  ~PreviewServer() override;

  void OnFrame(const CapturedFrame& before,
               const UndistortedFrame& after) override;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PREVIEW_SERVER_H
