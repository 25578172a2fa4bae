#include "camera_arguments.h"

#include <getopt.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <variant>
#include <vector>

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

using Arguments = CameraArguments;
using Parse = void (*)(const char* text, Arguments* arguments);

// An option and its effect: a flag, a text, or a value that is parsed.
struct CameraOption {
  const char* name;
  std::variant<bool Arguments::*, std::string Arguments::*, Parse> effect;
};

// The first two have the short forms -o and -h.
const CameraOption kOptions[] = {
    {"output", &Arguments::output},
    {"help", &Arguments::is_help},
    {"list", &Arguments::is_list},
    {"source",
     [](auto* text, Arguments* a) {
       text ? ParseSource(text, a) : void(a->is_list = true);
     }},
    {"camera",
     [](auto* text, Arguments* a) {
       ChooseCamera(CameraKind::kLibcamera, text, a);
     }},
    {"format", &Arguments::format},
    {"size", ParseSize},
    {"table",
     [](auto* text, Arguments* a) {
       a->table = static_cast<unsigned>(ParseCount("--table", text, 0, 15));
     }},
    {"serial", &Arguments::serial},
    {"calibrated-crop",
     [](auto* text, Arguments* a) { a->calibrated_crop = ParseCrop(text); }},
    {"strict", &Arguments::is_strict},
    {"control",
     [](auto* text, Arguments* a) {
       a->controls.push_back(ParseControl(text));
     }},
    {"from", &Arguments::recording},
    {"fps",
     [](auto* text, Arguments* a) {
       a->frames_per_second = ParseNumber("--fps", text, 0.01, 10000);
     }},
    {"timeout",
     [](auto* text, Arguments* a) {
       a->timeout_s = ParseNumber("--timeout", text, 0.1, 86400);
     }},
    {"png", &Arguments::as_png},
    {"outside",
     [](auto* text, Arguments* a) { a->only_valid = ParseOutside(text); }},
    {"frames",
     [](auto* text, Arguments* a) {
       a->num_frames = ParseCount("--frames", text, 1, 1e15);
     }},
    {"every-frame", &Arguments::every_frame},
    {"live", &Arguments::is_live},
    {"threads",
     [](auto* text, Arguments* a) {
       a->num_threads =
           static_cast<unsigned>(ParseCount("--threads", text, 1, 256));
     }},
    {"http", [](auto* text, Arguments* a) { ParseHttp(text, a); }},
    {"http-name",
     [](auto* text, Arguments* a) { a->http.more_names.push_back(text); }},
    {"listen", [](auto* text, Arguments* a) { a->http.number = text; }},
    {"token-file", [](auto* text, Arguments* a) { a->http.token_file = text; }},
    {"points", &Arguments::points},
    {"benchmark", &Arguments::is_benchmark},
    {"check", &Arguments::is_check},
    {"quiet", &Arguments::is_quiet}};
constexpr int kFirstLongOption = 256;

void Apply(const CameraOption& option, const char* text, Arguments* arguments) {
  if (const auto* flag = std::get_if<0>(&option.effect))
    arguments->*(*flag) = true;
  else if (const auto* value = std::get_if<1>(&option.effect))
    arguments->*(*value) = text;
  else
    std::get<Parse>(option.effect)(text, arguments);
}

// The options for getopt_long(), which returns kFirstLongOption + index.
std::vector<option> ListLongOptions() {
  std::vector<option> options;
  for (const CameraOption& each : kOptions)
    options.push_back({each.name,
                       each.effect.index() == 0             ? no_argument
                       : each.name == std::string("source") ? optional_argument
                                                            : required_argument,
                       nullptr,
                       kFirstLongOption + static_cast<int>(options.size())});
  options.push_back({});
  return options;
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
  const std::vector<option> options = ListLongOptions();
  int which;
  while ((which = getopt_long(argc, argv, ":o:h", options.data(), nullptr)) !=
         -1) {
    if (which == '?')
      FailUsage(std::string(argv[optind - 1]) + ": unknown option");
    if (which == ':')
      FailUsage(std::string(argv[optind - 1]) + ": missing value");
    const CameraOption& chosen =
        kOptions[which == 'o'   ? 0
                 : which == 'h' ? 1
                                : which - kFirstLongOption];
    // The value may be a separate argument, as for other options.
    if (chosen.name == std::string("source") && !optarg && optind < argc &&
        argv[optind][0] != '-')
      optarg = argv[optind++];
    Apply(chosen, optarg, &arguments);
  }
  if (optind < argc) arguments.blob = argv[optind++];
  if (optind < argc)
    FailUsage(std::string(argv[optind]) + ": more than one blob specified");
  CheckTogether(arguments);
  return arguments;
}

}  // namespace raygrid
