#include "mjpeg_stream.h"

#include <cstdio>

namespace raygrid {
namespace {

constexpr size_t kMaxPartHeaderBytes = 128;  // at most

}  // namespace

MjpegStream::MjpegStream(size_t max_size)
    : NewestStream("multipart/x-mixed-replace; boundary=frame", "",
                   max_size + kMaxPartHeaderBytes) {}

void MjpegStream::ShowImage(const uint8_t* jpeg, size_t size) {
  char header[kMaxPartHeaderBytes];
  const int length = std::snprintf(
      header, sizeof(header),
      "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %zu\r\n\r\n",
      size);
  Publish({{header, static_cast<size_t>(length)},
           {reinterpret_cast<const char*>(jpeg), size},
           "\r\n"});
}

}  // namespace raygrid
