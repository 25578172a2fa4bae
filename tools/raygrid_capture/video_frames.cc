#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "camera_error.h"
#include "camera_session.h"
#include "dataset/error.h"
#include "live_frames.h"
#include "pipe_source.h"

extern char** environ;

namespace raygrid {
namespace {

// A file descriptor, or the read end of a pipe from a decoder process.
class VideoStream {
 public:
  static VideoStream OpenFile(const std::string& path) {
    VideoStream stream;
    stream.fd_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (stream.fd_ < 0)
      throw InputError(
          fmt::format("{}: cannot be read ({})", path, std::strerror(errno)));
    return stream;
  }

  static VideoStream OpenProgram(const std::string& path) {
    VideoStream stream;
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw InputError(fmt::format("{}: cannot create a pipe ({})", path,
                                   std::strerror(errno)));
    stream.fd_ = ends[0];
    // The prefix prevents ffmpeg from interpreting a file name as a URL.
    const std::string file = "file:" + path;
    const char* const arguments[] = {
        "ffmpeg",       "-nostdin", "-v",    "error",    "-noautorotate", "-i",
        file.c_str(),   "-map",     "0:v:0", "-pix_fmt", "gray",          "-f",
        "yuv4mpegpipe", "-strict",  "-1",    "pipe:1",   nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    const int failure =
        posix_spawnp(&stream.program_, arguments[0], &actions, nullptr,
                     const_cast<char**>(arguments), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (failure != 0) {
      stream.program_ = 0;
      throw InputError(
          fmt::format("{}: cannot run ffmpeg to decode it ({}); install it, or "
                      "use Y4M or MJPEG",
                      path, std::strerror(failure)));
    }
    return stream;
  }

  VideoStream(VideoStream&& other) noexcept
      : fd_(other.fd_), program_(other.program_) {
    other.fd_ = -1;
    other.program_ = 0;
  }
  ~VideoStream() {
    if (fd_ >= 0) close(fd_);
    if (program_ == 0) return;
    kill(program_, SIGTERM);
    waitpid(program_, nullptr, 0);
  }

  int fd() const { return fd_; }

 private:
  VideoStream() = default;

  int fd_ = -1;
  pid_t program_ = 0;
};

bool IsReadWithoutFfmpeg(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension();
  return extension == ".y4m" || extension == ".mjpeg" || extension == ".mjpg";
}

class VideoSource : public PipeSource {
 public:
  explicit VideoSource(VideoStream stream)
      : PipeSource(stream.fd(), Options(), IsSignalled),
        stream_(std::move(stream)) {}
  ~VideoSource() override { Stop(); }

 private:
  static PipeOptions Options() {
    PipeOptions options = {};
    options.every_frame = true;
    options.timeout_s = 20;  // ffmpeg may probe much of a file
    return options;
  }

  const VideoStream stream_;
};

}  // namespace

std::unique_ptr<LiveFrames> MakeVideoFrames(const std::string& path) {
  try {
    return MakeSourceFrames(
        std::make_unique<VideoSource>(IsReadWithoutFfmpeg(path)
                                          ? VideoStream::OpenFile(path)
                                          : VideoStream::OpenProgram(path)),
        false);
  } catch (const CameraError& error) {
    throw InputError(
        fmt::format("{}: cannot decode the video ({})", path, error.what()));
  }
}

}  // namespace raygrid
