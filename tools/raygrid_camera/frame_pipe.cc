#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstring>
#include <utility>

#include "frame_output.h"

namespace raygrid {
namespace {

constexpr int kPatience_ms = 50;
constexpr std::chrono::seconds kGrace(1);

// Returns the number of bytes that can be written without blocking after poll()
// has reported the descriptor as writable.
size_t GetMaxWriteSize(int fd) {
  struct stat status;
  const bool is_file = fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
  return is_file ? SSIZE_MAX : PIPE_BUF;
}

class FramePipe : public FrameOutput {
 public:
  FramePipe(int fd, std::function<bool()> is_stopped)
      : fd_(fd),
        piece_(GetMaxWriteSize(fd)),
        is_stopped_(std::move(is_stopped)) {}

  void Write(const UndistortedFrame& frame, uint64_t) override {
    const uint8_t* next = frame.bytes.data();
    size_t left = frame.bytes.size();
    while (left > 0) {
      WaitForReader();
      const ssize_t written = write(fd_, next, std::min(left, piece_));
      if (written < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (written < 0) Fail(std::strerror(errno));
      next += written;
      left -= static_cast<size_t>(written);
    }
  }

 private:
  void WaitForReader() {
    std::optional<Clock::time_point> give_up;
    pollfd waiting = {fd_, POLLOUT, 0};
    while (poll(&waiting, 1, kPatience_ms) <= 0) {
      if (!is_stopped_()) continue;
      if (!give_up) give_up = Clock::now() + kGrace;
      if (Clock::now() > *give_up) Fail("the reading process has stalled");
    }
  }

  [[noreturn]] void Fail(const std::string& why) const {
    throw CameraError(CameraExit::kOutput,
                      "standard output: the last frame is incomplete (" + why +
                          "); keep the reader running");
  }

  const int fd_;
  const size_t piece_;
  const std::function<bool()> is_stopped_;
};

}  // namespace

std::unique_ptr<FrameOutput> MakePipe(int fd,
                                      std::function<bool()> is_stopped) {
  return std::make_unique<FramePipe>(fd, std::move(is_stopped));
}

std::string DescribePipe(const StreamFormat& format, double frames_per_second) {
  const std::string width = std::to_string(format.width);
  const std::string height = std::to_string(format.height);
  const std::string rate = std::to_string(std::lround(frames_per_second));
  const PixelFormatInfo& names = *format.pixel_format;
  std::string text;
  if (names.ffmpeg)
    text += std::string("ffplay -f rawvideo -pixel_format ") + names.ffmpeg +
            " -video_size " + width + "x" + height + " -framerate " + rate +
            " -\n";
  if (const std::string name = RawVideoParseName(names); !name.empty())
    text += std::string("gst-launch-1.0 fdsrc ! rawvideoparse format=") + name +
            " width=" + width + " height=" + height + " framerate=" + rate +
            "/1 ! videoconvert ! autovideosink\n";
  return text;
}

}  // namespace raygrid
