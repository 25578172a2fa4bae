/// The page of a live capture over HTTP: live image, next view, and progress of
/// the calibration.
#ifndef RAYGRID_CAPTURE_CAPTURE_PAGE_H
#define RAYGRID_CAPTURE_CAPTURE_PAGE_H

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "capture_state.h"
#include "page_server.h"
#include "stream_format.h"

namespace raygrid {

/// A command from a button of the page.
struct CaptureCommand {
  enum class Kind { kPause, kGoOn, kUndo, kFinish, kDelete };
  Kind kind = Kind::kPause;
  std::string name;  ///< frame to delete; else empty
};

/// 8-bit grey, rows without padding.
struct GreyBuffer {
  int width = 0, height = 0;
  std::vector<uint8_t> bytes;
};

/// Serves the page and its files, the state as server-sent events (/state), the
/// live picture as motion JPEG (/live), kept frames as thumbnails
/// (/kept/NAME.jpg) and in full size (/picture/NAME.jpg), and accepts commands:
/// POST /pause, /go-on, /undo, /finish and /delete?name=NAME. PageServer
/// controls access. Paths are compared with known ones, never opened.
///
/// Pictures are encoded in separate threads, and only while a client watches;
/// slow clients receive fewer. Thumbnails of kept frames stay in memory, at
/// most 24 kB each. Thread-safe.
class CapturePage {
 public:
  /// Called by the server's thread, which it blocks: only store the command.
  using OnCommand = std::function<void(const CaptureCommand&)>;
  /// Reads a kept frame from disk; returns false if it cannot. Called by a
  /// thread of the page, one frame at a time. Must not throw.
  using KeptFrameReader =
      std::function<bool(const std::string& name, GreyBuffer*)>;

  /// Throws CameraError if the port is in use, or the token is not readable.
  CapturePage(const PageAddress& address, const PageOptionNames& words,
              OnCommand on_command, KeptFrameReader read_kept);
  /// Still sends the last state, and the end of the capture, to all clients.
  ~CapturePage();

  uint16_t port() const;
  /// Returns the address of the page, with the token if it is random.
  std::string link() const;
  bool has_new_token() const;

  /// Sends a state, and discards thumbnails of frames that it does not contain.
  void Show(const CaptureState& state);

  /// Copies the frame if a client watches.
  void ShowImage(const StreamFormat& format, const rg_image& image);
  void ShowImage(const uint8_t* grey, int width, int height, size_t row_bytes);

  /// Adds the thumbnail of a kept frame of the next state.
  void AddKept(const std::string& name, const uint8_t* grey, int width,
               int height, size_t row_bytes);

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_PAGE_H
