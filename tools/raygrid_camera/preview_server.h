/// A page with the frames before and after, as motion JPEG over HTTP.
#ifndef RAYGRID_CAMERA_PREVIEW_SERVER_H
#define RAYGRID_CAMERA_PREVIEW_SERVER_H

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "undistorter.h"

namespace raygrid {

struct PreviewAddress {
  std::string number = "127.0.0.1";  // numerical; that is this machine only
  uint16_t port = 0;
  std::vector<std::string> more_names;  // see host_names.h
};

/// Serves "/", "/before" and "/after", nothing else. Encodes only while someone
/// looks, on a thread of its own; who is slow sees fewer frames. No client can
/// make it keep more than a few kilobytes and one picture, and there are at
/// most 16 that watch. Requests under another name than the server's are
/// refused.
class PreviewServer : public FrameObserver {
 public:
  /// Throws CameraError where the port is taken.
  PreviewServer(const PreviewAddress& address, const StreamFormat& before,
                const StreamFormat& after);
  ~PreviewServer() override;

  void OnFrame(const CapturedFrame& before,
               const UndistortedFrame& after) override;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PREVIEW_SERVER_H
