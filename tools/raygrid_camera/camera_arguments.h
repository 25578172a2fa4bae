#ifndef RAYGRID_CAMERA_CAMERA_ARGUMENTS_H
#define RAYGRID_CAMERA_CAMERA_ARGUMENTS_H

#include <optional>
#include <string>

#include "frame_source.h"
#include "preview_server.h"

namespace raygrid {

enum class CameraKind { kAny, kLibcamera, kV4l2 };

struct CameraArguments {
  std::string blob;
  CameraKind source = CameraKind::kAny;
  std::string camera;  // libcamera id or a part of it; V4L2 path
  std::string format;
  unsigned width = 0, height = 0;  // 0: size in the blob
  std::optional<unsigned> table;   // index of the remap table
  std::string serial;
  std::optional<SensorCrop> calibrated_crop;
  ControlValues controls;  // camera controls in order
  std::string recording;   // file with frames instead of a camera; "-": stdin
  bool is_live = false;    // frames do not wait for a slow output
  double frames_per_second = 30;  // rate of the recording
  std::string output;             // folder; "-": standard output
  bool as_png = false;
  bool only_valid = false;  // border outside the valid region
  bool every_frame = false;
  bool is_strict = false;    // stop at frames not as calibrated
  unsigned num_threads = 0;  // 0: all processors but one
  uint64_t num_frames = 0;   // 0: unlimited
  double timeout_s = 5;
  std::string points;  // file; "-": standard input
  PageAddress http;    // port 0: no server
  bool is_benchmark = false;
  bool is_check = false;  // a single frame, without output
  bool is_list = false, is_help = false, is_quiet = false;
};

extern const char kCameraHelp[];

/// Parses arguments. Throws CameraError (wrong usage).
CameraArguments ParseCameraArguments(int argc, char** argv);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_ARGUMENTS_H
