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
  std::string token_file;               // empty: none
};

/// Serves "/", "/before" and "/after", nothing else. Encodes only while someone
/// looks, on a thread of its own; who is slow sees fewer frames. No client can
/// make it keep more than a few kilobytes and one picture, and there are at
/// most 16 that watch. Requests under another name than the server's are
/// refused.
///
/// Who asks at an address that other machines reach must know a token: as the
/// page's link has it, in a cookie that the link sets, or as
/// "Authorization: Bearer TOKEN". So it is at loopback if the token is told.
class PreviewServer : public FrameObserver {
 public:
  /// Throws CameraError where the port is taken, or the token cannot be had.
  PreviewServer(const PreviewAddress& address, const StreamFormat& before,
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
