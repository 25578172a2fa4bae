/// A page with the frames before and after undistortion, as motion JPEG.
#ifndef RAYGRID_CAMERA_PREVIEW_SERVER_H
#define RAYGRID_CAMERA_PREVIEW_SERVER_H

#include <memory>
#include <string>

#include "page_server.h"
#include "undistorter.h"

namespace raygrid {

/// Serves only "/", "/before" and "/after". Encodes frames in a separate thread
/// while a client watches; slow clients receive fewer frames. PageServer
/// controls access.
class PreviewServer : public FrameObserver {
 public:
  /// Throws CameraError if the port is in use, or the token is not readable.
  PreviewServer(const PageAddress& address, const StreamFormat& before,
                const StreamFormat& after);
  ~PreviewServer() override;

  /// Returns the address of the page, with the token if it is random.
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
