#include "camera_arguments.h"

#include <getopt.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "camera_error.h"
#include "control_arguments.h"

namespace raygrid {

const char kCameraHelp[] =
    "Undistorts a camera's frames with the table of a raygrid blob.\n"
    "\n"
    "Usage: raygrid-camera BLOB [options]\n"
    "       raygrid-camera --source\n"
    "       raygrid-camera capture --help\n"
    "  BLOB  packed with --remap, and --mode for frames of other modes\n"
    "  capture  takes the images that calibrate a camera, by the calibrator's\n"
    "        program raygrid-capture\n"
    "\n"
    "Camera\n"
    "  --source, --list   cameras, their formats, sizes and controls\n"
    "  --source KIND[:CAMERA]  libcamera:ID, or v4l2:/dev/video0 for the "
    "kernel's\n"
    "                     own devices (default: the only one of libcamera, "
    "where\n"
    "                     that is built in)\n"
    "  --camera ID        as --source libcamera:ID; a part of the id is "
    "enough\n"
    "  --format NAME      libcamera's pixel format, or MJPEG of V4L2 (default: "
    "the\n"
    "                     camera's)\n"
    "  --size WxH         to ask the camera for (default: the blob's)\n"
    "  --table N          which of the blob's tables, from 0 (default: the one "
    "of\n"
    "                     the frames' sensor mode, or 0)\n"
    "  --serial S         the camera's serial number; the blob's must be the "
    "same\n"
    "  --calibrated-crop X,Y,WxH  the part of the sensor that was calibrated, "
    "to\n"
    "                     know other modes by\n"
    "  --strict           ends with exit code 8 at a frame that is not as the "
    "blob\n"
    "                     records calibration; else that is said once, and "
    "counted\n"
    "  --control NAME=VALUE  sets a control of the camera, before the first "
    "frame;\n"
    "                     may be given again\n"
    "  --from FILE        raw frames of a file, again and again, instead of a\n"
    "                     camera; with --format, and --fps N (default: 30)\n"
    "  --from -           frames of standard input: raw ones with --format "
    "and\n"
    "                     --size, Y4M, or JPEGs one behind the other\n"
    "  --live             frames of --from do not wait for a slow output, as "
    "those\n"
    "                     of a camera (default: every frame is written)\n"
    "  --timeout S        seconds without a frame that end it (default: 5)\n"
    "\n"
    "Output\n"
    "  -o, --output DIR   frame-000000.raw and so on: a text header that ends\n"
    "                     with a line \"...\", and the planes\n"
    "  --png              frame-000000.png and so on instead\n"
    "  -o -               planes to standard output, for ffplay or\n"
    "                     gst-launch-1.0 (how is told on standard error)\n"
    "  --outside WHAT     what is shown where nothing was seen while "
    "calibrating:\n"
    "                     fill, as the lens goes on there (default); trusted,\n"
    "                     border in blocks of 8 pixels of the view in which "
    "nothing\n"
    "                     is trusted\n"
    "  --frames N         ends after N frames\n"
    "  --every-frame      frames of a camera wait for a slow output; else the "
    "oldest\n"
    "                     is given up for a newer one, and numbers of files "
    "have a\n"
    "                     gap\n"
    "  --threads N        that undistort each frame (default: all processors "
    "but one)\n"
    "  --http PORT        a page with frames before and after, for this "
    "machine\n"
    "                     alone: 127.0.0.1\n"
    "  --listen ADDRESS   the page is at this address instead, 0.0.0.0 for "
    "all;\n"
    "                     who asks must know a token: the link that is "
    "printed\n"
    "                     has it\n"
    "  --token-file FILE  the token, instead of a new one each time; also for\n"
    "                     127.0.0.1\n"
    "  --http-name NAME[:PORT]  a name besides the machine's own, and its\n"
    "                     addresses', that the page may be asked for by\n"
    "  --points FILE      undistorts positions instead of pixels: lines x,y "
    "of\n"
    "                     FILE (- is standard input) to lines x,y,u,v on\n"
    "                     standard output; u,v are empty where there is none.\n"
    "                     With a blob of a range, a third number of a line is\n"
    "                     where its frame was taken: dioptres or degrees. It\n"
    "                     stands for the lines behind it, too; before that,\n"
    "                     the first frame tells it\n"
    "  --benchmark        ends after 90 frames, and tells on standard output: "
    "frames\n"
    "                     a second; milliseconds for reading a frame from the\n"
    "                     camera's memory, the remap, the output, and copying "
    "as\n"
    "                     many bytes of other memory; whether caches serve "
    "the\n"
    "                     camera's memory; threads\n"
    "  --check            takes and undistorts one frame, and tells in a line "
    "what\n"
    "                     was found; writes and serves nothing, so the other "
    "options\n"
    "                     may stay\n"
    "  --quiet            no statistics\n"
    "\n"
    "Statistics: frames a second; milliseconds in the remap, and waiting for "
    "it\n"
    "and for the output (median, 99th percentile); frames that arrived, were\n"
    "taken by the output, given up here, or missed by the camera; frames not "
    "as\n"
    "calibrated, where the blob records that: raygrid pack "
    "--capture-settings.\n"
    "Exit codes: 0 done, 1 usage, 2 camera or input, 7 output, 8 blob.\n"
    "\n"
    "As a service of systemd, raygrid-camera@NAME takes blob and options from\n"
    "/etc/raygrid/NAME.conf; README.md of raygrid says how.\n"
    "\n"
    "Example:\n"
    "  raygrid-camera front.raygrid --check\n"
    "  raygrid-camera front.raygrid --http 8080\n"
    "  raygrid-camera front.raygrid -o frames/ --frames 100\n";

namespace {

[[noreturn]] void FailUsage(const std::string& message) {
  throw CameraError(CameraExit::kUsage, message + "; see --help");
}

double ParseNumber(const std::string& option, const char* text, double low,
                   double high) {
  char* end;
  const double value = std::strtod(text, &end);
  if (end == text || *end != 0 || !(value >= low && value <= high))
    FailUsage(option + ": " + text + " is no number from " +
              std::to_string(std::lround(low)) + " to " +
              std::to_string(std::llround(high)));
  return value;
}

uint64_t ParseCount(const std::string& option, const char* text, double low,
                    double high) {
  const double value = ParseNumber(option, text, low, high);
  if (value != std::floor(value)) FailUsage(option + ": not a whole number");
  return static_cast<uint64_t>(value);
}

void ParseSize(const char* text, CameraArguments* arguments) {
  char more;
  if (std::sscanf(text, "%5ux%5u%c", &arguments->width, &arguments->height,
                  &more) != 2 ||
      arguments->width == 0 || arguments->height == 0)
    FailUsage(std::string("--size: ") + text + " is not like 640x480");
}

SensorCrop ParseCrop(const char* text) {
  SensorCrop crop;
  char more;
  if (std::sscanf(text, "%6d,%6d,%6ux%6u%c", &crop.x, &crop.y, &crop.width,
                  &crop.height, &more) != 4 ||
      crop.width == 0 || crop.height == 0)
    FailUsage(std::string("--calibrated-crop: ") + text +
              " is not like 0,0,3280x2464");
  return crop;
}

void ChooseCamera(CameraKind kind, const std::string& camera,
                  CameraArguments* arguments) {
  if (arguments->source != CameraKind::kAny)
    FailUsage("--source, --camera: one camera is enough");
  arguments->source = kind;
  arguments->camera = camera;
}

void ParseSource(const std::string& text, CameraArguments* arguments) {
  const size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  if (kind != "libcamera" && kind != "v4l2")
    FailUsage("--source: " + text +
              " is not like v4l2:/dev/video0 or libcamera:ID");
  ChooseCamera(kind == "v4l2" ? CameraKind::kV4l2 : CameraKind::kLibcamera,
               colon == std::string::npos ? "" : text.substr(colon + 1),
               arguments);
}

// Whether only what is trusted is to be shown.
bool ParseOutside(const std::string& text) {
  if (text != "fill" && text != "trusted")
    FailUsage("--outside: " + text + " is neither fill nor trusted");
  return text == "trusted";
}

void ParseHttp(const std::string& text, CameraArguments* arguments) {
  const size_t colon = text.rfind(':');
  if (colon != std::string::npos) {
    arguments->http.number = text.substr(0, colon);
    if (arguments->http.number.empty()) FailUsage("--http: no address");
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

void TakeOption(int which, CameraArguments* arguments) {
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
      arguments->only_trusted = ParseOutside(optarg);
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
    FailUsage("--png: needs a folder, -o DIR");
  if (!arguments.points.empty() &&
      (!arguments.output.empty() || arguments.http.port != 0))
    FailUsage("--points: instead of -o and --http");
  if (!arguments.points.empty() && arguments.only_trusted)
    FailUsage("--outside: is for frames; leave it out with --points");
  if (arguments.is_benchmark &&
      (arguments.num_frames != 0 || !arguments.points.empty()))
    FailUsage("--benchmark: leave --frames and --points out");
  if (arguments.is_check &&
      (arguments.is_benchmark || !arguments.points.empty()))
    FailUsage("--check: leave --benchmark and --points out");
  if (!arguments.http.more_names.empty() && arguments.http.port == 0)
    FailUsage("--http-name: needs --http");
  if (arguments.http.number != PageAddress().number && arguments.http.port == 0)
    FailUsage("--listen: needs --http PORT");
  if (!arguments.http.token_file.empty() && arguments.http.port == 0)
    FailUsage("--token-file: needs --http PORT");
  if (!arguments.recording.empty() && arguments.source != CameraKind::kAny)
    FailUsage("--from: instead of a camera; leave --source or --camera out");
  if (!arguments.recording.empty() && !arguments.controls.empty())
    FailUsage("--control: is for cameras; leave it out with --from");
  if (arguments.is_live && arguments.recording.empty())
    FailUsage("--live: is for --from; leave it out, as cameras are live");
  if (arguments.is_live && arguments.every_frame)
    FailUsage("--live: leave --every-frame out, which is the opposite");
  if (arguments.recording == "-" && arguments.points == "-")
    FailUsage("--points: of a file, where --from reads standard input");
  if (!arguments.recording.empty() && arguments.recording != "-" &&
      arguments.format.empty())
    FailUsage("--from: needs --format");
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
      FailUsage(std::string(argv[optind - 1]) + ": needs a value");
    // A value that stands apart, as those of other options may.
    if (which == kSource && !optarg && optind < argc && argv[optind][0] != '-')
      optarg = argv[optind++];
    TakeOption(which, &arguments);
  }
  if (optind < argc) arguments.blob = argv[optind++];
  if (optind < argc)
    FailUsage(std::string(argv[optind]) + ": one blob is enough");
  CheckTogether(arguments);
  return arguments;
}

}  // namespace raygrid
