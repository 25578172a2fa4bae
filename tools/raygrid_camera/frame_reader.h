/// Readers of frames from a byte stream.
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
    kComplete,
    kDamaged,
    kEnd,
    kTruncated  // the stream ended within a frame
  };

  virtual ~FrameReader() = default;
  virtual const StreamFormat& format() const = 0;
  /// Reads the next frame, rows without padding, to format().packed_size()
  /// bytes at `frame`. Throws CameraError if the stream cannot be decoded.
  virtual Outcome Read(uint8_t* frame) = 0;
  /// Returns the remedy for a truncated stream.
  virtual const char* remedy() const {
    return "see the messages of the program that writes it";
  }
};

/// Returns a reader for the stream: Y4M by its header; concatenated JPEGs if
/// the format is MJPEG or empty; otherwise raw frames of the format and size.
/// Throws CameraError if the stream is none of them. The stream must outlive
/// the reader.
std::unique_ptr<FrameReader> MakeFrameReader(InputStream* stream,
                                             const std::string& format,
                                             unsigned width, unsigned height);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_READER_H
