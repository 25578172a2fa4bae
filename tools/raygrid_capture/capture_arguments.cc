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
#include "control_arguments.h"
#include "dataset/error.h"
#include "frame_sources.h"
#include "image_size_option.h"
#include "named_camera.h"
#include "pattern_input.h"

namespace raygrid {
namespace {

// "0.02px", or without the unit.
double ParsePixels(const std::string& option, const std::string& text) {
  char* end;
  const double value = std::strtod(text.c_str(), &end);
  const std::string unit = end;
  if (end == text.c_str() || (!unit.empty() && unit != "px") ||
      !(value > 0 && value < 1e3))
    throw Error(
        ExitCode::kUsage,
        fmt::format("{} {}: expected pixels, such as 0.02px", option, text));
  return value;
}

// "v4l2:/dev/video0", "libcamera:imx708", "libcamera"; false for files.
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

// A camera's or a file's path without links; what is none stays as it is.
std::string PlaceOf(const std::string& source) {
  CameraArguments camera;
  const std::string name =
      ParseCamera(source, &camera) ? camera.camera : source;
  std::error_code error;
  const auto place = std::filesystem::canonical(name, error);
  return error ? source : place.string();
}

// Two sources that are one, by whatever path, would be a rig of one camera.
void RequireDifferentSources(const std::vector<NamedValue>& sources) {
  for (size_t k = 1; k < sources.size(); ++k)
    for (size_t before = 0; before < k; ++before)
      if (PlaceOf(sources[before].value) == PlaceOf(sources[k].value))
        throw Error(ExitCode::kUsage,
                    fmt::format("--source {}={}: the source of {} again; give "
                                "each camera its own",
                                sources[k].name, sources[k].value,
                                sources[before].name));
}

// Opens a source; NULL if a signal came first.
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
    if (!source) return nullptr;  // a signal came first
    return MakeSourceFrames(std::move(source), !can_wait);
  }
  struct stat status;
  if (stat(name.c_str(), &status) != 0)
    throw InputError(name +
                     ": is neither a camera, as v4l2:/dev/video0 or libcamera, "
                     "nor a file or folder; --list names cameras");
  return S_ISDIR(status.st_mode) ? MakeFolderFrames(name)
                                 : MakeVideoFrames(name);
}

}  // namespace

void AddCaptureOptions(CLI::App* app, CaptureArguments* arguments) {
  app->add_flag_callback(
      "--list",
      [] {
        std::fputs(DescribeCameras().c_str(), stdout);
        throw CLI::Success();
      },
      "print the cameras, their formats, sizes and controls; nothing else is "
      "needed");
  app->add_option("--source", arguments->sources,
                  "libcamera[:ID], v4l2[:DEVICE], a video, a folder of images, "
                  "or - for Y4M, JPEGs or raw frames on standard input; of a "
                  "rig NAME=SOURCE, once for each camera")
      ->required()
      ->type_name("SOURCE")
      ->allow_extra_args(false);
  app->add_option("--pair-within-ms", arguments->pair_within_ms,
                  "a rig's frames are of one instant if their time stamps "
                  "differ by no more; photographs are by their names, frames "
                  "of videos by their numbers")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  AddPatternOption(app, &arguments->pattern)->required();
  AddYes(app, &arguments->common);
  app->add_option("-o,--output", arguments->output,
                  "the session's folder, to be made: frames/, session.json and "
                  "pattern.yaml")
      ->required();
  app->add_option("--until", arguments->until,
                  "done once 95 % of the image's places are known to so many "
                  "pixels, such as 0.02px; otherwise once no view would take "
                  "away 2 % of the variance; never before ten frames");
  app->add_flag("--resume", arguments->resume,
                "go on with the folder's session");
  app->add_flag("--no-calibrate", arguments->no_calibrate,
                "do not run raygrid calibrate at the end");
  app->add_option("--size", arguments->size, "WxH to ask the camera for");
  app->add_option("--format", arguments->format,
                  "libcamera's pixel format, or MJPEG of V4L2, to ask the "
                  "camera for; of raw frames on standard input");
  app->add_option("--control", arguments->controls,
                  "NAME=VALUE sets a control of the camera before the first "
                  "frame; may be given again")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app->add_option("--still-px", arguments->loop.judge.still_px,
                  "frames are kept whose features moved by less since the last "
                  "one, or while it was exposed")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  app->add_flag("--every-frame", arguments->loop.judge.every_frame,
                "keep every frame in which the board is seen, of a camera that "
                "moves, until the source ends or Ctrl-C: calibrate "
                "--rolling-shutter follows, which tells the time of a row");
  app->add_option("--timeout", arguments->loop.timeout_s,
                  "seconds without a frame that end it")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app->add_flag(
      "--no-page", arguments->no_page,
      "no page in a browser: the terminal shows the same. Without it, "
      "the link is printed; videos and folders have no page");
  app->add_option("--listen", arguments->page.number,
                  "address of the page; others than loopback's need the token "
                  "that the printed link has")
      ->capture_default_str();
  app->add_option("--port", arguments->page.port,
                  "of the page; 0: any that is free")
      ->capture_default_str();
  app->add_option("--page-name", arguments->page.more_names,
                  "another name of this machine that browsers may ask for, "
                  "NAME or NAME:PORT; may be given again")
      ->allow_extra_args(false);
  app->add_option("--token-file", arguments->page.token_file,
                  "file with the page's token: 16 to 128 letters, digits, - or "
                  "_");
  app->add_option("--threads", arguments->common.threads,
                  "threads; 0 means all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app->add_flag("--quiet", arguments->common.quiet, "print errors only");
  app->add_flag("--json", arguments->common.json,
                "print a line of JSON when something changes");
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
    sources = ParseNamedCameras("--source", "SOURCE", arguments.sources);
  RequireDifferentSources(sources);
  std::vector<NamedFrames> cameras;
  for (const auto& [name, source] : sources) {
    auto frames = OpenLiveFrames(arguments, source);
    if (!frames) return nullptr;
    cameras.push_back({name, std::move(frames)});
  }
  return std::make_unique<PairedFrames>(std::move(cameras),
                                        arguments.pair_within_ms * 1e-3);
}

}  // namespace raygrid
