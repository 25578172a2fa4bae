#include "input_stream.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "camera_error.h"

namespace raygrid {
namespace {

constexpr size_t kPieceBytes = 65536;
constexpr int kInputPatience_ms = 50;

}  // namespace

InputStream::InputStream(int fd, std::function<bool()> is_stopped)
    : fd_(fd), is_stopped_(std::move(is_stopped)) {}

size_t InputStream::Await(size_t number) {
  if (size() >= number) return size();
  if (begin_ > 0) {
    std::memmove(bytes_.data(), bytes_.data() + begin_, size());
    end_ -= begin_;
    begin_ = 0;
  }
  while (end_ < number) {
    if (bytes_.size() < end_ + kPieceBytes)
      bytes_.resize(2 * (end_ + kPieceBytes));
    const size_t came = ReadSome(bytes_.data() + end_, bytes_.size() - end_);
    if (came == 0) break;
    end_ += came;
  }
  return size();
}

size_t InputStream::Read(uint8_t* to, size_t number) {
  size_t done = std::min(number, size());
  std::copy_n(data(), done, to);
  Take(done);
  while (done < number) {
    const size_t came = ReadSome(to + done, number - done);
    if (came == 0) break;
    done += came;
  }
  return done;
}

// Returns 0 at the end of the stream.
size_t InputStream::ReadSome(uint8_t* to, size_t number) {
  while (!is_over_ && !is_stopped_()) {
    pollfd waiting = {fd_, POLLIN, 0};
    if (poll(&waiting, 1, kInputPatience_ms) <= 0) continue;
    const ssize_t came = read(fd_, to, number);
    if (came > 0) return static_cast<size_t>(came);
    if (came < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (came < 0)
      throw CameraError(CameraExit::kInput,
                        std::string("standard input: ") + std::strerror(errno) +
                            "; pipe frames or redirect a file to it");
    is_over_ = true;
  }
  return 0;
}

}  // namespace raygrid
