#include "capture_arguments.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "camera_arguments.h"
#include "camera_error.h"
#include "camera_values.h"
#include "control_arguments.h"
#include "dataset/error.h"
#include "frame_sources.h"
#include "help_formatter.h"
#include "image_size_option.h"
#include "pattern_input.h"

namespace raygrid {
namespace {

// Parses "0.02px"; the unit is optional.
double ParsePixels(const std::string& option, const std::string& text) {
  char* end;
  const double value = std::strtod(text.c_str(), &end);
  const std::string unit = end;
  if (end == text.c_str() || (!unit.empty() && unit != "px") ||
      !(value > 0 && value < 1e3))
    throw Error(
        ExitCode::kUsage,
        fmt::format("{} {}: expected a number of pixels, such as 0.02px",
                    option, text));
  return value;
}

// Parses "v4l2:/dev/video0", "libcamera:imx708" or "libcamera"; returns false
// for files.
bool ParseCamera(const std::string& source, CameraArguments* camera) {
  for (const auto& [word, kind] :
       {std::pair("libcamera", CameraKind::kLibcamera),
        std::pair("v4l2", CameraKind::kV4l2)}) {
    const std::string start = std::string(word) + ":";
    if (source != word && source.rfind(start, 0) != 0) continue;
    camera->source = kind;
    if (source != word) camera->camera = source.substr(start.size());
    return true;
  }
  return false;
}

// Returns the canonical path of a camera device or file; other sources are
// returned unchanged.
std::string FindSourceLocation(const std::string& source) {
  CameraArguments camera;
  const std::string name =
      ParseCamera(source, &camera) ? camera.camera : source;
  std::error_code error;
  const auto place = std::filesystem::canonical(name, error);
  return error ? source : place.string();
}

// Throws if two sources are the same device or file, even if the paths differ:
// they would form a rig with a zero baseline.
void RequireDifferentSources(const std::vector<NamedValue>& sources) {
  for (size_t k = 1; k < sources.size(); ++k)
    for (size_t before = 0; before < k; ++before)
      if (FindSourceLocation(sources[before].value) ==
          FindSourceLocation(sources[k].value))
        throw Error(ExitCode::kUsage,
                    fmt::format("--source {}={}: same source as camera {}; use "
                                "a different source for each camera",
                                sources[k].name, sources[k].value,
                                sources[before].name));
}

// Opens a source; NULL if a signal is received before.
std::unique_ptr<LiveFrames> OpenLiveFrames(const CaptureArguments& arguments,
                                           const std::string& name) {
  CameraArguments camera;
  camera.format = arguments.format;
  camera.timeout_s = arguments.loop.timeout_s;
  if (!arguments.size.empty()) {
    const ImageSize size = ParseImageSize("--size", arguments.size);
    camera.width = static_cast<unsigned>(size.width);
    camera.height = static_cast<unsigned>(size.height);
  }
  for (const std::string& control : arguments.controls)
    camera.controls.push_back(ParseControl(control));
  const bool is_input = name == "-";
  if (is_input || ParseCamera(name, &camera)) {
    if (is_input) camera.recording = "-";
    const bool can_wait = is_input && CanFramesWait(camera);
    camera.every_frame = can_wait;
    auto source = OpenFrameSource(camera);
    if (!source) return nullptr;  // a signal was received
    return MakeSourceFrames(std::move(source), !can_wait);
  }
  struct stat status;
  if (stat(name.c_str(), &status) != 0)
    throw InputError(name +
                     ": no such camera, file or folder; for cameras such as "
                     "v4l2:/dev/video0 see --list");
  return S_ISDIR(status.st_mode) ? MakeFolderFrames(name)
                                 : MakeVideoFrames(name);
}

}  // namespace

void AddCaptureOptions(CLI::App* app, CaptureArguments* arguments) {
  app->get_help_ptr()
      ->description("print this help")
      ->group(help_group::kAdvanced);
  BeginGroup(app, help_group::kInput);
  app->add_option(
         "--source", arguments->sources,
         "libcamera[:ID], v4l2[:DEVICE], a video file, a folder of images, or "
         "- (standard input); NAME=SOURCE for each camera of a rig")
      ->required()
      ->option_text("SOURCE")
      ->allow_extra_args(false);
  app->add_flag_callback(
      "--list",
      [] {
        std::fputs(DescribeCameras().c_str(), stdout);
        throw CLI::Success();
      },
      "list cameras with formats, sizes and controls, and exit");
  app->add_option("--size", arguments->size, "frame size to request in px")
      ->option_text("WxH");
  app->add_option("--format", arguments->format,
                  "pixel format to request: libcamera's name, or MJPEG; with "
                  "--source -, the format of the raw frames")
      ->option_text("NAME");
  app->add_option("--control", arguments->controls,
                  "camera control to set before the first frame; repeatable")
      ->option_text("NAME=VALUE")
      ->allow_extra_args(false);
  app->add_option("--pair-within-ms", arguments->pair_within_ms,
                  "maximum timestamp difference between the images of a frame "
                  "(images are paired by name, videos by frame number)")
      ->option_text("MS")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  AddPatternOption(app, &arguments->pattern)->required();
  AddYesOption(app, &arguments->common);
  BeginGroup(app, "Selection");
  app->add_option(
         "--until", arguments->until,
         "stop when the predicted uncertainty is below this limit in 95 % of "
         "the image (default: when no view reduces the variance by 2 %)")
      ->option_text("PX");
  app->add_option("--still-px", arguments->loop.frame_selector.still_px,
                  "keep a frame only if its features move by less than this "
                  "during the exposure, or since the previous frame if the "
                  "exposure time is unknown")
      ->option_text("PX")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  app->add_flag("--every-frame", arguments->loop.frame_selector.every_frame,
                "keep every frame that shows the target, for calibrate "
                "--rolling-shutter");
  BeginGroup(app, help_group::kOutput);
  app->add_option("-o,--output", arguments->output,
                  "session folder to create: frames/, session.json and "
                  "pattern.yaml")
      ->option_text("DIR")
      ->required();
  app->add_flag("--resume", arguments->resume,
                "continue the session in the output folder");
  app->add_flag("--no-calibrate", arguments->no_calibrate,
                "do not run raygrid calibrate at the end");
  BeginGroup(app, "Page");
  app->add_flag("--no-page", arguments->no_page,
                "do not serve a web page; print the state in the terminal");
  app->add_option("--listen", arguments->page.number,
                  "address to listen on; access from other hosts requires the "
                  "token in the printed link")
      ->option_text("ADDRESS")
      ->capture_default_str();
  app->add_option("--port", arguments->page.port,
                  "port of the web server; 0: any free port")
      ->option_text("PORT")
      ->capture_default_str();
  app->add_option("--page-name", arguments->page.more_names,
                  "additional host name accepted by the web server; repeatable")
      ->option_text("NAME[:PORT]")
      ->allow_extra_args(false);
  app->add_option("--token-file", arguments->page.token_file,
                  "file with the access token: 16 to 128 letters, digits, - or "
                  "_ (default: random token)")
      ->option_text("FILE");
  BeginGroup(app, help_group::kAdvanced);
  app->add_option("--timeout", arguments->loop.timeout_s,
                  "stop if no frame arrives for this time")
      ->option_text("S")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app->add_option("--threads", arguments->common.threads,
                  "number of threads; 0: one per core")
      ->option_text("N")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app->add_flag("--quiet", arguments->common.quiet, "print errors only");
  app->add_flag("--json", arguments->common.json,
                "print one line of JSON at each state change");
}

void FinishCaptureArguments(CaptureArguments* arguments) {
  if (!arguments->until.empty())
    arguments->loop.guide.target_px = ParsePixels("--until", arguments->until);
  arguments->loop.source =
      fmt::format("{}", fmt::join(arguments->sources, ", "));
  arguments->loop.num_threads = arguments->common.threads;
}

std::unique_ptr<PairedFrames> OpenFrames(const CaptureArguments& arguments) {
  std::vector<NamedValue> sources = {{"", arguments.sources[0]}};
  if (arguments.sources.size() > 1)
    sources = ParseCameraValues("--source", "SOURCE", arguments.sources);
  RequireDifferentSources(sources);
  std::vector<CameraStream> cameras;
  for (const auto& [name, source] : sources) {
    auto frames = OpenLiveFrames(arguments, source);
    if (!frames) return nullptr;
    cameras.push_back({name, std::move(frames)});
  }
  return std::make_unique<PairedFrames>(std::move(cameras),
                                        arguments.pair_within_ms * 1e-3);
}

}  // namespace raygrid
