#include "camera_session.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "benchmark.h"
#include "camera_check.h"
#include "camera_error.h"
#include "camera_statistics.h"
#include "capture_guard.h"
#include "frame_numbers.h"
#include "frame_output.h"
#include "points.h"
#include "preview_server.h"
#include "service_notice.h"
#include "stream_guard.h"
#include "undistorter.h"

namespace raygrid {
namespace {

constexpr std::chrono::milliseconds kFramePatience(50);

volatile sig_atomic_t is_signalled = 0;

void OnSignal(int) { is_signalled = 1; }

std::unique_ptr<FrameOutput> MakeOutput(const CameraArguments& arguments,
                                        const StreamFormat& format) {
  if (arguments.output.empty()) return nullptr;
  if (arguments.output == "-") {
    if (!arguments.is_quiet)
      std::fputs(DescribePipe(format, arguments.frames_per_second).c_str(),
                 stderr);
    return MakePipe(STDOUT_FILENO, IsSignalled);
  }
  if (arguments.as_png) return MakePngFiles(arguments.output, format);
  return MakeRawFiles(arguments.output, format);
}

std::unique_ptr<PreviewServer> MakePreview(const CameraArguments& arguments,
                                           const StreamFormat& before,
                                           const StreamFormat& after) {
  if (arguments.http.port == 0) return nullptr;
  auto preview = std::make_unique<PreviewServer>(arguments.http, before, after);
  if (!arguments.is_quiet || preview->has_new_token())
    std::fprintf(stderr, "%s\n", preview->link().c_str());
  return preview;
}

// Throws if no frame arrives for too long.
class FrameTimeout {
 public:
  explicit FrameTimeout(const CameraArguments& arguments)
      : limit_(std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(arguments.timeout_s))),
        is_input_(arguments.recording == "-") {}

  void Refresh() { last_ = Clock::now(); }
  void Check() const {
    if (Clock::now() - last_ > limit_)
      throw CameraError(CameraExit::kInput,
                        is_input_
                            ? "standard input: no frame within --timeout; "
                              "check the writing program, or increase --timeout"
                            : "camera: no frame within --timeout; reconnect "
                              "it, or increase --timeout");
  }

 private:
  const Clock::duration limit_;
  const bool is_input_;
  Clock::time_point last_ = Clock::now();
};

// Reads frames until the end; returns the number of frames written.
class FrameLoop {
 public:
  FrameLoop(const CameraArguments& arguments, const FrameSource& source,
            const CaptureGuard& capture, Undistorter* undistorter,
            FrameOutput* output, Benchmark* benchmark)
      : arguments_(arguments),
        source_(source),
        capture_(capture),
        undistorter_(undistorter),
        output_(output),
        benchmark_(benchmark),
        statistics_(capture, arguments.is_quiet),
        patience_(arguments) {}

  void Run() {
    while (!IsSignalled() && !HasEnoughFrames() &&
           !undistorter_->is_finished()) {
      ProcessFrame();
      statistics_.ShowPeriodically(source_.counts(), *undistorter_);
    }
  }

  // Also writes the pending frames after a signal or the end of the source.
  void Finish() {
    while (!HasEnoughFrames() && !undistorter_->is_finished()) ProcessFrame();
    statistics_.ShowSummary(source_.counts(), *undistorter_);
  }

 private:
  bool HasEnoughFrames() const {
    if (benchmark_) return benchmark_->is_complete();
    return arguments_.num_frames != 0 && written_ == arguments_.num_frames;
  }

  void ProcessFrame() {
    UndistortedFrame* const frame = undistorter_->Take(kFramePatience);
    if (!frame) return Wait();
    statistics_.Count(*frame);
    const Clock::time_point start = Clock::now();
    if (output_) output_->Write(*frame, numbers_.Next(frame->info.sequence));
    if (benchmark_) benchmark_->Count(*frame, Clock::now() - start);
    if (!arguments_.is_check) notice_.OnFrame();
    ++written_;
    undistorter_->ReturnFrame(frame);
    patience_.Refresh();
  }

  // Frames that are held back also reset the timeout; at the end of the stream,
  // the timeout does not apply.
  void Wait() {
    const uint64_t held_back = capture_.num_held_back();
    if (held_back != held_back_) patience_.Refresh();
    held_back_ = held_back;
    if (!undistorter_->is_finished()) patience_.Check();
  }

  const CameraArguments& arguments_;
  const FrameSource& source_;
  const CaptureGuard& capture_;
  Undistorter* const undistorter_;
  FrameOutput* const output_;
  Benchmark* const benchmark_;  // NULL: no measurements
  CameraStatistics statistics_;
  FrameTimeout patience_;
  ServiceNotice notice_;
  FrameNumbers numbers_;
  uint64_t written_ = 0, held_back_ = 0;
};

// Returns the first frame; nullopt if a signal is received before.
std::optional<FrameInfo> WaitForFrame(const CameraArguments& arguments,
                                      FrameSource* source) {
  FrameTimeout patience(arguments);
  while (!IsSignalled()) {
    if (const auto frame = source->Next(kFramePatience)) {
      source->Release(*frame);
      return frame->info;
    }
    if (!source->fault().empty())
      throw CameraError(CameraExit::kInput, source->fault());
    patience.Check();
  }
  return std::nullopt;
}

// Whether the remap table is selected by the first frame.
bool IsTableOpen(const CameraArguments& arguments, const FrameSource& source,
                 const rg_camera& camera) {
  return !arguments.table && source.reports_crops() && HasTablesOfModes(camera);
}

// Selects the blob's table that matches this frame; keeps the current one if
// there is none.
void SelectTable(const CameraArguments& arguments, const FrameSource& source,
                 const CaptureGuard& capture, const FrameInfo& info,
                 rg_camera* camera) {
  const uint32_t table = FindTable(
      *camera, source.format(),
      arguments.calibrated_crop ? arguments.calibrated_crop : capture.crop(),
      info.crop, capture.GetFlips(info));
  if (table != RG_NO_TABLE) rg_select_remap(camera, table);
}

std::string GetSourceName(const CameraArguments& arguments) {
  if (arguments.recording == "-") return "standard input";
  return arguments.recording.empty() ? "the camera" : arguments.recording;
}

// Prints a line over the statistics if on a terminal.
void PrintLine(const std::string& text) {
  std::fprintf(stderr, "%sraygrid-camera: %s\n",
               isatty(STDERR_FILENO) == 1 ? "\x1b[K" : "", text.c_str());
}

unsigned AllProcessorsButOne() {
  return std::max(2u, std::thread::hardware_concurrency()) - 1;
}

void PrintBenchmark(const CameraArguments& arguments,
                    const Benchmark& benchmark) {
  if (benchmark.is_complete())
    std::fputs(benchmark.Describe().c_str(),
               arguments.output == "-" ? stderr : stdout);
  else if (!IsSignalled())
    throw CameraError(CameraExit::kInput,
                      "--benchmark: only " +
                          std::to_string(benchmark.num_counted()) +
                          " frames received, requires " +
                          std::to_string(Benchmark::kNumFrames));
}

void StreamFrames(const CameraArguments& arguments, rg_camera camera,
                  CaptureGuard* capture, FrameSource* source) {
  const bool is_table_open = IsTableOpen(arguments, *source, camera);
  if (is_table_open) {
    source->Start();
    if (const auto info = WaitForFrame(arguments, source))
      SelectTable(arguments, *source, *capture, *info, &camera);
  }
  StreamGuard guard(camera, source->format(), StreamGuard::Use::kFrames,
                    arguments.serial, arguments.calibrated_crop, capture);
  guard.CheckFormat();  // before any output is created
  if (!arguments.is_quiet && !source->memory().empty())
    std::fprintf(stderr, "frame buffers: %s\n", source->memory().c_str());
  UndistorterOptions options;
  options.every_frame = arguments.every_frame;
  options.only_valid = arguments.only_valid;
  options.num_threads =
      arguments.num_threads > 0 ? arguments.num_threads : AllProcessorsButOne();
  std::unique_ptr<Benchmark> benchmark;
  if (arguments.is_benchmark)
    benchmark = std::make_unique<Benchmark>(source, options.num_threads);
  std::unique_ptr<PreviewServer> preview;  // outlives its frame producers
  Undistorter undistorter(camera, benchmark ? benchmark->source() : source,
                          &guard, options);
  const auto output = MakeOutput(arguments, undistorter.format());
  preview = MakePreview(arguments, source->format(), undistorter.format());
  FrameLoop loop(arguments, *source, *capture, &undistorter, output.get(),
                 benchmark.get());
  if (!is_table_open) source->Start();
  undistorter.Start(preview.get());
  loop.Run();
  undistorter.Stop();
  source->Stop();
  loop.Finish();
  capture->Finish();
  if (const auto fault = undistorter.fault()) throw *fault;
  if (benchmark) PrintBenchmark(arguments, *benchmark);
  if (arguments.is_check)
    std::fputs(DescribeCheck(arguments, *source, undistorter).c_str(), stdout);
}

// Converts positions in the camera's frames to positions in the undistorted
// view. The operating point is set from the first frame, and then from the
// metadata of each position.
void StreamPoints(const CameraArguments& arguments, rg_camera camera,
                  CaptureGuard* capture, FrameSource* source) {
  StreamGuard guard(camera, source->format(), StreamGuard::Use::kPositions,
                    arguments.serial, arguments.calibrated_crop, capture);
  source->Start();
  auto info = WaitForFrame(arguments, source);
  if (info && IsTableOpen(arguments, *source, camera))
    SelectTable(arguments, *source, *capture, *info, &camera);
  while (info && !guard.Check(*info)) info = WaitForFrame(arguments, source);
  source->Stop();
  capture->Finish();
  OperatingPointFollower stack(&camera);
  if (info) stack.Follow(*info);
  if (stack.counts().num_missing > 0)
    PrintLine(
        "the frame does not report its operating point: using the reference of "
        "the blob, unless a point has a third number");
  UndistortPoints(camera, guard.mode(), arguments.points, stdout, IsSignalled,
                  &stack);
  if (const uint64_t num = stack.counts().outside)
    PrintLine(std::to_string(num) + (num == 1 ? " value is" : " values are") +
              " outside the blob's range and clamped");
}

}  // namespace

void InstallSignalHandlers() {
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESETHAND;  // no SA_RESTART: signals interrupt reads
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = SIG_IGN;
  action.sa_flags = 0;
  sigaction(SIGPIPE, &action, nullptr);
  sigaction(SIGXFSZ, &action, nullptr);
}

bool IsSignalled() { return is_signalled != 0; }

void RunCameraSession(const CameraArguments& arguments, const rg_camera& camera,
                      const std::optional<rg_capture_section>& recorded,
                      FrameSource* source) {
  CaptureGuard capture(recorded, GetSourceName(arguments), arguments.is_strict,
                       PrintLine);
  if (arguments.is_check)
    return StreamFrames(MakeCheckArguments(arguments), camera, &capture,
                        source);
  if (arguments.points.empty())
    return StreamFrames(arguments, camera, &capture, source);
  StreamPoints(arguments, camera, &capture, source);
}

}  // namespace raygrid
