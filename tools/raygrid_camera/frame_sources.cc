#include "frame_sources.h"

#include <sys/stat.h>
#include <unistd.h>

#include <vector>

#include "atomic_file.h"
#include "camera_error.h"
#include "camera_session.h"
#include "jpeg_reader.h"
#include "memory_source.h"
#include "pipe_source.h"

#if RAYGRID_HAS_LIBCAMERA
#include "libcamera_source.h"
#endif
#if RAYGRID_HAS_V4L2
#include "v4l2_list.h"
#include "v4l2_source.h"
#endif

namespace raygrid {
namespace {

std::unique_ptr<FrameSource> OpenRecording(const CameraArguments& arguments) {
  const PixelFormatInfo& info = RequirePixelFormat(arguments.format);
  MemorySourceOptions options;
  options.frames_per_second = arguments.frames_per_second;
  options.every_frame = arguments.every_frame;
  return std::make_unique<MemorySource>(
      MakeStreamFormat(info, arguments.width, arguments.height, 0),
      ReadFileBytes(arguments.recording), options);
}

std::unique_ptr<FrameSource> OpenInput(const CameraArguments& arguments) {
  PipeOptions options;
  options.format = arguments.format;
  options.width = arguments.width;
  options.height = arguments.height;
  options.every_frame = arguments.every_frame;
  options.timeout_s = arguments.timeout_s;
  try {
    return std::make_unique<PipeSource>(STDIN_FILENO, options, IsSignalled);
  } catch (const CameraError&) {
    if (!IsSignalled()) throw;
    return nullptr;
  }
}

#if RAYGRID_HAS_LIBCAMERA

const CameraList& Cameras() {
  static const CameraList cameras;
  return cameras;
}

std::string DescribeLibcamera() { return Cameras().Describe(); }

std::unique_ptr<FrameSource> OpenLibcamera(const CameraArguments& arguments) {
  return std::make_unique<LibcameraSource>(
      Cameras().Find(arguments.camera),
      LibcameraOptions{arguments.format, arguments.width, arguments.height,
                       arguments.every_frame, arguments.controls});
}

#else

std::string DescribeLibcamera() { return ""; }

std::unique_ptr<FrameSource> OpenLibcamera(const CameraArguments&) {
  throw CameraError(CameraExit::kUsage,
                    "--source: built without libcamera; use v4l2");
}

#endif
#if RAYGRID_HAS_V4L2

std::string DescribeV4l2() { return DescribeV4l2Devices(); }

// Returns the only device that captures frames.
std::string FindOnlyDevice() {
  const std::vector<std::string> paths = FindV4l2Devices();
  if (paths.size() == 1) return paths[0];
  throw CameraError(CameraExit::kInput,
                    paths.empty()
                        ? "no accessible V4L2 device; connect a camera, or "
                          "add the user to the group video"
                        : "several cameras found; select one (see --list), "
                          "such as --source v4l2:" +
                              paths[0]);
}

std::unique_ptr<FrameSource> OpenV4l2(const CameraArguments& arguments) {
  const std::string path =
      arguments.camera.empty() ? FindOnlyDevice() : arguments.camera;
  return std::make_unique<V4l2Source>(
      OpenV4l2Device(path),
      V4l2Options{arguments.format, arguments.width, arguments.height,
                  arguments.every_frame, arguments.controls, DecodeJpeg});
}

#else

std::string DescribeV4l2() { return ""; }

std::unique_ptr<FrameSource> OpenV4l2(const CameraArguments&) {
  throw CameraError(CameraExit::kUsage,
                    "--source: built without V4L2; use libcamera");
}

#endif

}  // namespace

std::unique_ptr<FrameSource> OpenFrameSource(const CameraArguments& arguments) {
  if (arguments.recording == "-") return OpenInput(arguments);
  if (!arguments.recording.empty()) return OpenRecording(arguments);
  switch (arguments.source) {
    case CameraKind::kLibcamera:
      return OpenLibcamera(arguments);
    case CameraKind::kV4l2:
      return OpenV4l2(arguments);
    case CameraKind::kAny:
      break;
  }
  return RAYGRID_HAS_LIBCAMERA ? OpenLibcamera(arguments) : OpenV4l2(arguments);
}

bool CanFramesWait(const CameraArguments& arguments) {
  struct stat status;
  return arguments.recording == "-" && fstat(STDIN_FILENO, &status) == 0 &&
         S_ISREG(status.st_mode);
}

std::string DescribeCameras() {
  const std::string text = DescribeLibcamera() + DescribeV4l2();
  if (text.empty())
    throw CameraError(CameraExit::kInput,
                      "camera: none found; connect one, and check that this "
                      "user is in the group video");
  return text;
}

}  // namespace raygrid
