#include "picture_stream.h"

#include <cstdio>

namespace raygrid {
namespace {

constexpr size_t kPartHeader = 128;  // at most

}  // namespace

PictureStream::PictureStream(size_t max_size)
    : NewestStream("multipart/x-mixed-replace; boundary=frame", "",
                   max_size + kPartHeader) {}

void PictureStream::ShowPicture(const uint8_t* jpeg, size_t size) {
  char header[kPartHeader];
  const int length = std::snprintf(
      header, sizeof(header),
      "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %zu\r\n\r\n",
      size);
  Publish({{header, static_cast<size_t>(length)},
           {reinterpret_cast<const char*>(jpeg), size},
           "\r\n"});
}

}  // namespace raygrid
