#include "camera_arguments.h"

#include <getopt.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "camera_error.h"
#include "control_arguments.h"

namespace raygrid {

const char kCameraHelp[] =
    R"(Undistort a camera's frames with a remap table of a raygrid blob.

Usage: raygrid-camera BLOB [OPTIONS]
       raygrid-camera --list
       raygrid-camera capture [OPTIONS]    (see raygrid-camera capture --help)

BLOB is packed with raygrid pack --remap, and --mode for other sensor modes.

Input:
  --list                  list cameras, formats, sizes and controls
  --source KIND[:CAMERA]  libcamera:ID or v4l2:/dev/video0 (default: the only
                          camera of libcamera); see --list
  --camera ID             same as --source libcamera:ID; a unique part suffices
  --format NAME           pixel format of libcamera, or MJPEG of V4L2 (default:
                          the camera's)
  --size WxH              frame size to request (default: the blob's)
  --control NAME=VALUE    camera control to set at the start; repeatable
  --from FILE             raw frames from FILE, repeated; requires --format
  --fps N                 frame rate for --from FILE (default: 30)
  --from -                standard input: Y4M, JPEGs, or raw frames with
                          --format and --size
  --live                  drop input frames if the output is too slow
                          (default: process every frame)
  --timeout S             exit after this time without a frame (default: 5)

Model:
  --table N               0-based index of the remap table (default: that of the
                          sensor mode, or 0)
  --serial S              reject the blob unless its serial number is S
  --calibrated-crop X,Y,WxH  sensor region of the calibrated images, to identify
                          other sensor modes
  --strict                exit with code 8 if the capture settings of a frame
                          differ from the blob's (default: warn and count)
  --outside WHAT          outside the valid region: fill (extrapolate, default)
                          or border (use the border value)

Output:
  -o,--output DIR         frame-000000.raw and so on: a text header up to a line
                          "...", then the planes
  --png                   write PNG files instead of raw frames
  -o -                    planes to standard output, for ffplay or
                          gst-launch-1.0, whose arguments are printed to stderr
  --frames N              exit after N frames
  --every-frame           wait for slow outputs instead of dropping old frames
  --http PORT             serve a web page with original and undistorted frames
                          (by default on 127.0.0.1 only)
  --listen ADDRESS        address to listen on, 0.0.0.0: all; clients need the
                          token in the printed link
  --token-file FILE       file with the access token (default: random), which
                          127.0.0.1 then requires, too
  --http-name NAME[:PORT] additional host name accepted by the web server
  --points FILE           undistort points instead of frames: lines x,y of FILE
                          (-: standard input) to x,y,u,v; a third number is the
                          operating point, in dioptres or degrees

Advanced:
  --check                 undistort one frame and report camera, table and
                          settings; write no files
  --benchmark             exit after 90 frames and print frame rate and times of
                          reading, remap, output and memory copies
  --threads N             threads per frame (default: number of processors - 1)
  --quiet                 print no statistics
  --help                  print this help

Exit codes: 0 success, 1 usage, 2 camera or input, 7 output, 8 blob.
As a systemd service: see tools/raygrid_camera/README.md.

Example:
  raygrid-camera front.raygrid --http 8080
)";

namespace {

[[noreturn]] void FailUsage(const std::string& message) {
  throw CameraError(CameraExit::kUsage, message + "; see --help");
}

double ParseNumber(const std::string& option, const char* text, double low,
                   double high) {
  char* end;
  const double value = std::strtod(text, &end);
  if (end == text || *end != 0 || !(value >= low && value <= high))
    FailUsage(option + ": " + text + " is not a number from " +
              std::to_string(std::lround(low)) + " to " +
              std::to_string(std::llround(high)));
  return value;
}

uint64_t ParseCount(const std::string& option, const char* text, double low,
                    double high) {
  const double value = ParseNumber(option, text, low, high);
  if (value != std::floor(value)) FailUsage(option + ": not an integer");
  return static_cast<uint64_t>(value);
}

void ParseSize(const char* text, CameraArguments* arguments) {
  char more;
  if (std::sscanf(text, "%5ux%5u%c", &arguments->width, &arguments->height,
                  &more) != 2 ||
      arguments->width == 0 || arguments->height == 0)
    FailUsage(std::string("--size: ") + text +
              ": expected WIDTHxHEIGHT, such as 640x480");
}

SensorCrop ParseCrop(const char* text) {
  SensorCrop crop;
  char more;
  if (std::sscanf(text, "%6d,%6d,%6ux%6u%c", &crop.x, &crop.y, &crop.width,
                  &crop.height, &more) != 4 ||
      crop.width == 0 || crop.height == 0)
    FailUsage(std::string("--calibrated-crop: ") + text +
              ": expected X,Y,WxH, such as 0,0,3280x2464");
  return crop;
}

void ChooseCamera(CameraKind kind, const std::string& camera,
                  CameraArguments* arguments) {
  if (arguments->source != CameraKind::kAny)
    FailUsage("--source, --camera: more than one camera specified");
  arguments->source = kind;
  arguments->camera = camera;
}

void ParseSource(const std::string& text, CameraArguments* arguments) {
  const size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  if (kind != "libcamera" && kind != "v4l2")
    FailUsage("--source: " + text +
              ": expected v4l2:/dev/video0 or libcamera:ID");
  ChooseCamera(kind == "v4l2" ? CameraKind::kV4l2 : CameraKind::kLibcamera,
               colon == std::string::npos ? "" : text.substr(colon + 1),
               arguments);
}

// Whether output is restricted to the valid region.
bool ParseOutside(const std::string& text) {
  const bool is_border = text == "border" || text == "trusted";  // former name
  if (text != "fill" && !is_border)
    FailUsage("--outside: " + text + ": expected fill or border");
  return is_border;
}

void ParseHttp(const std::string& text, CameraArguments* arguments) {
  const size_t colon = text.rfind(':');
  if (colon != std::string::npos) {
    arguments->http.number = text.substr(0, colon);
    if (arguments->http.number.empty()) FailUsage("--http: missing address");
  }
  const std::string port =
      colon == std::string::npos ? text : text.substr(colon + 1);
  arguments->http.port =
      static_cast<uint16_t>(ParseCount("--http", port.c_str(), 1, 65535));
}

enum Option : int {
  kOutput = 'o',
  kHelp = 'h',
  kList = 256,
  kSource,
  kCamera,
  kFormat,
  kSize,
  kTable,
  kSerial,
  kCrop,
  kStrict,
  kControl,
  kFrom,
  kFps,
  kTimeout,
  kPng,
  kOutside,
  kFrames,
  kEveryFrame,
  kLive,
  kThreads,
  kHttp,
  kHttpName,
  kListen,
  kTokenFile,
  kPoints,
  kBenchmark,
  kCheck,
  kQuiet
};

const option kOptions[] = {
    {"output", required_argument, nullptr, kOutput},
    {"help", no_argument, nullptr, kHelp},
    {"list", no_argument, nullptr, kList},
    {"source", optional_argument, nullptr, kSource},
    {"camera", required_argument, nullptr, kCamera},
    {"format", required_argument, nullptr, kFormat},
    {"size", required_argument, nullptr, kSize},
    {"table", required_argument, nullptr, kTable},
    {"serial", required_argument, nullptr, kSerial},
    {"calibrated-crop", required_argument, nullptr, kCrop},
    {"strict", no_argument, nullptr, kStrict},
    {"control", required_argument, nullptr, kControl},
    {"from", required_argument, nullptr, kFrom},
    {"fps", required_argument, nullptr, kFps},
    {"timeout", required_argument, nullptr, kTimeout},
    {"png", no_argument, nullptr, kPng},
    {"outside", required_argument, nullptr, kOutside},
    {"frames", required_argument, nullptr, kFrames},
    {"every-frame", no_argument, nullptr, kEveryFrame},
    {"live", no_argument, nullptr, kLive},
    {"threads", required_argument, nullptr, kThreads},
    {"http", required_argument, nullptr, kHttp},
    {"http-name", required_argument, nullptr, kHttpName},
    {"listen", required_argument, nullptr, kListen},
    {"token-file", required_argument, nullptr, kTokenFile},
    {"points", required_argument, nullptr, kPoints},
    {"benchmark", no_argument, nullptr, kBenchmark},
    {"check", no_argument, nullptr, kCheck},
    {"quiet", no_argument, nullptr, kQuiet},
    {nullptr, 0, nullptr, 0}};

void ApplyOption(int which, CameraArguments* arguments) {
  switch (which) {
    case kOutput:
      arguments->output = optarg;
      break;
    case kHelp:
      arguments->is_help = true;
      break;
    case kList:
      arguments->is_list = true;
      break;
    case kSource:
      if (optarg)
        ParseSource(optarg, arguments);
      else
        arguments->is_list = true;
      break;
    case kCamera:
      ChooseCamera(CameraKind::kLibcamera, optarg, arguments);
      break;
    case kFormat:
      arguments->format = optarg;
      break;
    case kSize:
      ParseSize(optarg, arguments);
      break;
    case kSerial:
      arguments->serial = optarg;
      break;
    case kCrop:
      arguments->calibrated_crop = ParseCrop(optarg);
      break;
    case kStrict:
      arguments->is_strict = true;
      break;
    case kControl:
      arguments->controls.push_back(ParseControl(optarg));
      break;
    case kFrom:
      arguments->recording = optarg;
      break;
    case kPng:
      arguments->as_png = true;
      break;
    case kOutside:
      arguments->only_valid = ParseOutside(optarg);
      break;
    case kEveryFrame:
      arguments->every_frame = true;
      break;
    case kLive:
      arguments->is_live = true;
      break;
    case kThreads:
      arguments->num_threads =
          static_cast<unsigned>(ParseCount("--threads", optarg, 1, 256));
      break;
    case kHttp:
      ParseHttp(optarg, arguments);
      break;
    case kHttpName:
      arguments->http.more_names.push_back(optarg);
      break;
    case kListen:
      arguments->http.number = optarg;
      break;
    case kTokenFile:
      arguments->http.token_file = optarg;
      break;
    case kPoints:
      arguments->points = optarg;
      break;
    case kBenchmark:
      arguments->is_benchmark = true;
      break;
    case kCheck:
      arguments->is_check = true;
      break;
    case kQuiet:
      arguments->is_quiet = true;
      break;
    case kTable:
      arguments->table =
          static_cast<unsigned>(ParseCount("--table", optarg, 0, 15));
      break;
    case kFps:
      arguments->frames_per_second = ParseNumber("--fps", optarg, 0.01, 10000);
      break;
    case kTimeout:
      arguments->timeout_s = ParseNumber("--timeout", optarg, 0.1, 86400);
      break;
    case kFrames:
      arguments->num_frames = ParseCount("--frames", optarg, 1, 1e15);
      break;
  }
}

void CheckTogether(const CameraArguments& arguments) {
  if (arguments.is_help || arguments.is_list) return;
  if (arguments.blob.empty()) FailUsage("usage: raygrid-camera BLOB [options]");
  if (arguments.as_png && (arguments.output.empty() || arguments.output == "-"))
    FailUsage("--png requires a folder, -o DIR");
  if (!arguments.points.empty() &&
      (!arguments.output.empty() || arguments.http.port != 0))
    FailUsage("--points cannot be combined with -o or --http");
  if (!arguments.points.empty() && arguments.only_valid)
    FailUsage("--outside applies to frames, not to --points");
  if (arguments.is_benchmark &&
      (arguments.num_frames != 0 || !arguments.points.empty()))
    FailUsage("--benchmark cannot be combined with --frames or --points");
  if (arguments.is_check &&
      (arguments.is_benchmark || !arguments.points.empty()))
    FailUsage("--check cannot be combined with --benchmark or --points");
  if (!arguments.http.more_names.empty() && arguments.http.port == 0)
    FailUsage("--http-name requires --http");
  if (arguments.http.number != PageAddress().number && arguments.http.port == 0)
    FailUsage("--listen requires --http PORT");
  if (!arguments.http.token_file.empty() && arguments.http.port == 0)
    FailUsage("--token-file requires --http PORT");
  if (!arguments.recording.empty() && arguments.source != CameraKind::kAny)
    FailUsage("--from cannot be combined with --source or --camera");
  if (!arguments.recording.empty() && !arguments.controls.empty())
    FailUsage("--control applies to cameras, not to --from");
  if (arguments.is_live && arguments.recording.empty())
    FailUsage("--live requires --from");
  if (arguments.is_live && arguments.every_frame)
    FailUsage("--live and --every-frame are mutually exclusive");
  if (arguments.recording == "-" && arguments.points == "-")
    FailUsage(
        "--points - cannot be combined with --from -; use a file for one of "
        "them");
  if (!arguments.recording.empty() && arguments.recording != "-" &&
      arguments.format.empty())
    FailUsage("--from FILE requires --format");
}

}  // namespace

CameraArguments ParseCameraArguments(int argc, char** argv) {
  CameraArguments arguments;
  opterr = 0;
  int which;
  while ((which = getopt_long(argc, argv, ":o:h", kOptions, nullptr)) != -1) {
    if (which == '?')
      FailUsage(std::string(argv[optind - 1]) + ": unknown option");
    if (which == ':')
      FailUsage(std::string(argv[optind - 1]) + ": missing value");
    // The value may be a separate argument, as for other options.
    if (which == kSource && !optarg && optind < argc && argv[optind][0] != '-')
      optarg = argv[optind++];
    ApplyOption(which, &arguments);
  }
  if (optind < argc) arguments.blob = argv[optind++];
  if (optind < argc)
    FailUsage(std::string(argv[optind]) + ": more than one blob specified");
  CheckTogether(arguments);
  return arguments;
}

}  // namespace raygrid
