/// A page with the frames before and after, as motion JPEG over HTTP.
#ifndef RAYGRID_CAMERA_PREVIEW_SERVER_H
#define RAYGRID_CAMERA_PREVIEW_SERVER_H

#include <memory>
#include <string>

#include "page_server.h"
#include "undistorter.h"

namespace raygrid {

/// Serves "/", "/before" and "/after", nothing else. Encodes only while someone
/// looks, on a thread of its own; who is slow sees fewer frames. PageServer
/// says who may ask.
class PreviewServer : public FrameObserver {
 public:
  /// Throws CameraError where the port is taken, or the token cannot be had.
  PreviewServer(const PageAddress& address, const StreamFormat& before,
                const StreamFormat& after);
  ~PreviewServer() override;

  /// The address of the page, with the token if that was made just now.
  std::string link() const;
  bool has_new_token() const;

  void OnFrame(const CapturedFrame& before,
               const UndistortedFrame& after) override;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PREVIEW_SERVER_H
