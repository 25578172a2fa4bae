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
  std::string camera;  // libcamera's id, or a part of it; V4L2's path
  std::string format;
  unsigned width = 0, height = 0;  // 0: the blob's
  std::optional<unsigned> table;   // of the blob's remap tables
  std::string serial;
  std::optional<SensorCrop> calibrated_crop;
  ControlValues controls;  // of the camera, in the order given
  std::string recording;   // frames of a file, not a camera; "-": of stdin
  bool is_live = false;    // they do not wait for a slow output
  double frames_per_second = 30;  // of the recording
  std::string output;             // folder; "-": standard output
  bool as_png = false;
  bool only_trusted = false;  // border where nothing is trusted
  bool every_frame = false;
  bool is_strict = false;    // frames not as calibrated end it
  unsigned num_threads = 0;  // 0: all processors but one
  uint64_t num_frames = 0;   // 0: until it is stopped
  double timeout_s = 5;
  std::string points;  // file; "-": standard input
  PageAddress http;    // port 0: no server
  bool is_benchmark = false;
  bool is_check = false;  // one frame, and nothing written
  bool is_list = false, is_help = false, is_quiet = false;
};

extern const char kCameraHelp[];

/// Throws CameraError (wrong usage).
CameraArguments ParseCameraArguments(int argc, char** argv);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_ARGUMENTS_H
