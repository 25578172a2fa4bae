// A person before a camera: looks at the page, holds the board where its
// outline is, a little off, until the page says done. The camera's images are
// rendered, so that its truth is known.
#include "capture_operator.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <mutex>
#include <thread>

#include "dataset/camera_file.h"
#include "evaluation/model_difference.h"
#include "evaluation/residual_statistics.h"
#include "simulation/simulated_camera_models.h"
#include "target/board_spec.h"
#include "temporary_folder.h"

extern char** environ;

namespace raygrid {
namespace {

using namespace std::chrono_literals;

constexpr ImageSize kOperatedSize = {640, 480};

// raygrid-capture with a pipe for its frames and one for what it says.
class CaptureProgram {
 public:
  CaptureProgram(const std::string& board, const std::string& session) {
    int frames[2], messages[2];
    if (pipe2(frames, O_CLOEXEC) != 0 || pipe2(messages, O_CLOEXEC) != 0)
      return;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, frames[0], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, messages[1], STDERR_FILENO);
    const char* const arguments[] = {RAYGRID_CAPTURE,
                                     "--source",
                                     "-",
                                     "--pattern",
                                     board.c_str(),
                                     "-o",
                                     session.c_str(),
                                     "--until",
                                     "0.02px",
                                     "--port",
                                     "0",
                                     "--timeout",
                                     "60",
                                     nullptr};
    posix_spawn(&program_, RAYGRID_CAPTURE, &actions, nullptr,
                const_cast<char**>(arguments), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(frames[0]);
    close(messages[1]);
    frames_ = frames[1];
    messages_ = messages[0];
  }
  ~CaptureProgram() {
    CloseFrames();
    close(messages_);
    if (program_ > 0) {
      kill(program_, SIGKILL);
      waitpid(program_, nullptr, 0);
    }
  }

  // False: it takes no more.
  bool Write(const void* bytes, size_t size) const {
    const char* at = static_cast<const char*>(bytes);
    while (size > 0) {
      const ssize_t written = write(frames_, at, size);
      if (written <= 0) return false;
      at += written;
      size -= static_cast<size_t>(written);
    }
    return true;
  }
  void CloseFrames() {
    if (frames_ >= 0) close(frames_);
    frames_ = -1;
  }
  // The port of the page, whose link is the first line.
  uint16_t Port() const {
    std::string line;
    for (char c; read(messages_, &c, 1) == 1 && c != '\n';) line += c;
    const size_t colon = line.rfind(':');
    return colon == std::string::npos
               ? 0
               : static_cast<uint16_t>(std::atoi(line.c_str() + colon + 1));
  }
  // Its exit code, once it has calibrated.
  int Wait() {
    char bytes[4096];
    while (read(messages_, bytes, sizeof(bytes)) > 0) {
    }
    int status = 0;
    waitpid(program_, &status, 0);
    program_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t program_ = 0;
  int frames_ = -1, messages_ = -1;
};

// Plays the newest picture, 30 times a second.
class Camera {
 public:
  explicit Camera(const CaptureProgram& program)
      : program_(program),
        picture_(
            static_cast<size_t>(kOperatedSize.width) * kOperatedSize.height,
            120),
        thread_([this] { Play(); }) {}
  ~Camera() { Stop(); }

  void Show(std::vector<uint8_t> picture) {
    const std::lock_guard<std::mutex> lock(mutex_);
    picture_ = std::move(picture);
  }
  void Stop() {
    is_stopped_ = true;
    if (thread_.joinable()) thread_.join();
  }
  bool is_stopped() const { return is_stopped_; }

 private:
  void Play() {
    const std::string header = "YUV4MPEG2 W640 H480 F30:1 Cmono\n";
    bool is_taken = program_.Write(header.data(), header.size());
    auto due = std::chrono::steady_clock::now();
    while (is_taken && !is_stopped_) {
      const std::string mark = "FRAME\n";
      std::vector<uint8_t> frame(mark.begin(), mark.end());
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        frame.insert(frame.end(), picture_.begin(), picture_.end());
      }
      is_taken = program_.Write(frame.data(), frame.size());
      due += 33ms;
      std::this_thread::sleep_until(due);
    }
    is_stopped_ = true;
  }

  const CaptureProgram& program_;
  std::mutex mutex_;
  std::vector<uint8_t> picture_;
  std::atomic<bool> is_stopped_{false};
  std::thread thread_;
};

TEST(CaptureOperator, FollowsThePageToAnAccurateCamera) {
  const std::string spec = "star:14x10:18mm";
  const auto truth = MakeSimulatedCamera("wide", kOperatedSize);
  const TemporaryFolder folder;
  const std::string session = folder / "session";
  std::signal(SIGPIPE, SIG_IGN);
  CaptureProgram program(spec, session);
  Camera camera(program);
  const uint16_t port = program.Port();
  ASSERT_NE(port, 0);
  constexpr int kPatience = 20;
  CaptureOperator person(*truth, ReadPatternOrSpec(spec).boards.front(),
                         kPatience);
  HttpClient page(port, "GET /state");
  const auto end = std::chrono::steady_clock::now() + 240s;
  while (!person.is_done() && std::chrono::steady_clock::now() < end) {
    const auto state = NextState(&page);
    if (!state) break;
    if (auto picture = person.Look(*state)) camera.Show(std::move(*picture));
  }
  EXPECT_TRUE(person.is_done())
      << person.num_kept() << " frames kept of " << person.num_views();
  camera.Stop();
  program.CloseFrames();
  EXPECT_EQ(program.Wait(), 0);
  const CameraFile found = ReadCameraFile(session + "/calibration/camera.yaml");
  const ModelDifference difference = CompareModels(*truth, *found.camera, 10);
  std::vector<double> errors_px;
  for (const Eigen::Vector2d& error : difference.error_px)
    errors_px.push_back(error.norm());
  RecordProperty("frames", static_cast<int>(person.num_kept()));
  std::printf("%zu frames kept of %d views, median %.4f px, 95 %% %.4f px\n",
              person.num_kept(), person.num_views(), Quantile(errors_px, 0.5),
              Quantile(errors_px, 0.95));
  EXPECT_LT(Quantile(errors_px, 0.5), 0.02);
}

}  // namespace
}  // namespace raygrid
