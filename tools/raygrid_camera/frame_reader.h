/// Frames of a stream of bytes.
#ifndef RAYGRID_CAMERA_FRAME_READER_H
#define RAYGRID_CAMERA_FRAME_READER_H

#include <memory>
#include <string>

#include "input_stream.h"
#include "stream_format.h"

namespace raygrid {

class FrameReader {
 public:
  enum class Outcome {
    kWhole,
    kDamaged,
    kEnd,
    kCut  // the stream ended within a frame
  };

  virtual ~FrameReader() = default;
  virtual const StreamFormat& format() const = 0;
  /// The next frame, rows without gaps, to a place of format().packed_size()
  /// bytes. Throws CameraError where the stream cannot be followed any more.
  virtual Outcome Read(uint8_t* frame) = 0;
  /// The remedy for a stream that is cut.
  virtual const char* remedy() const {
    return "see the messages of the program that writes it";
  }
};

/// The reader for what comes: Y4M by its header; JPEG, one picture behind the
/// other, for the format MJPEG or for none; else frames of that format and
/// size. Throws CameraError where the stream is none of them. It must outlive
/// the reader.
std::unique_ptr<FrameReader> MakeFrameReader(InputStream* stream,
                                             const std::string& format,
                                             unsigned width, unsigned height);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_READER_H
