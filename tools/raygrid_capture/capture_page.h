/// The page of a live capture: what the camera sees, what to do next, and what
/// is known by now, over HTTP.
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

/// A button of the page that somebody pressed.
struct CaptureCommand {
  enum class Kind { kPause, kGoOn, kUndo, kFinish, kDelete };
  Kind kind = Kind::kPause;
  std::string name;  ///< of the frame to delete; else empty
};

/// 8 bits, rows without gaps.
struct GreyPicture {
  int width = 0, height = 0;
  std::vector<uint8_t> bytes;
};

/// Serves the page and its files, the state as server-sent events (/state), the
/// live picture as motion JPEG (/live), kept frames small (/kept/NAME.jpg) and
/// whole (/picture/NAME.jpg), and takes commands: POST /pause, /go-on, /undo,
/// /finish and /delete?name=NAME. PageServer says who may ask. Paths are
/// compared with known ones, and none is opened.
///
/// Pictures are encoded only while someone looks, on a thread of their own; who
/// is slow sees fewer. Small pictures of kept frames stay in memory, at most
/// 24 kB each. All functions may be called by any thread.
class CapturePage {
 public:
  /// Called by the server's thread, which waits for it: put the command aside.
  using OnCommand = std::function<void(const CaptureCommand&)>;
  /// Reads a kept frame from disk; false: it cannot be read. Called by a thread
  /// of the page's own, one frame at a time. Must not throw.
  using ReadKept = std::function<bool(const std::string& name, GreyPicture*)>;

  /// Throws CameraError where the port is taken, or the token cannot be had.
  CapturePage(const PageAddress& address, const PageWords& words,
              OnCommand on_command, ReadKept read_kept);
  /// The last state that was shown still reaches those who watch, and that the
  /// capture has ended.
  ~CapturePage();

  uint16_t port() const;
  /// The address of the page, with the token if that was made just now.
  std::string link() const;
  bool has_new_token() const;

  /// Small pictures of frames that a state had and this one has not are
  /// forgotten.
  void Show(const CaptureState& state);

  /// Copies the frame, if someone looks.
  void ShowPicture(const StreamFormat& format, const rg_image& image);
  void ShowPicture(const uint8_t* grey, int width, int height,
                   size_t row_bytes);

  /// The small picture of a frame that the next state has among those kept.
  void AddKept(const std::string& name, const uint8_t* grey, int width,
               int height, size_t row_bytes);

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_PAGE_H
