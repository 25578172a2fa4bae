// raygrid-camera: undistorts the frames of a camera on the device.
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "camera_arguments.h"
#include "camera_check.h"
#include "camera_error.h"
#include "camera_session.h"
#include "capture_guard.h"
#include "frame_sources.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "sibling_program.h"
#include "stream_guard.h"

namespace raygrid {
namespace {

// A blob in memory, and the camera that accesses it in place.
struct Blob {
  std::vector<uint8_t> bytes;
  rg_camera camera;
  std::optional<rg_capture_section> capture;
};

// Required for --outside border: without a mask, rg_is_valid() returns true
// everywhere.
void RequireMask(const std::string& path, const std::vector<uint8_t>& bytes) {
  rg_blob blob;
  const rg_status status =
      rg_blob_open(bytes.data(), static_cast<uint32_t>(bytes.size()), &blob);
  if (status != RG_OK)
    throw CameraError(CameraExit::kBlob, path + ": " + rg_status_text(status) +
                                             "; pack or copy the blob again");
  if (blob.mask == 0)
    throw CameraError(
        CameraExit::kUsage,
        path +
            ": --outside border: the blob has no valid region; omit the "
            "option, or pack a camera.yaml written by raygrid calibrate");
}

Blob OpenBlob(const CameraArguments& arguments) {
  Blob blob;
  blob.bytes = ReadFileBytes(arguments.blob);
  rg_status status = RG_ERR_TRUNCATED;
  if (blob.bytes.size() < UINT32_MAX)
    status = rg_camera_open(&blob.camera, blob.bytes.data(),
                            static_cast<uint32_t>(blob.bytes.size()));
  if (status != RG_OK)
    throw CameraError(CameraExit::kBlob, arguments.blob + ": " +
                                             rg_status_text(status) +
                                             "; pack or copy the blob again");
  const unsigned table = arguments.table.value_or(0);
  status = rg_select_remap(&blob.camera, table);
  if (status != RG_OK)
    throw CameraError(
        CameraExit::kBlob,
        arguments.blob + ": " + DescribeTableFault(blob.camera, table));
  rg_view view;
  if (rg_remap_view(&blob.camera, &view) == RG_OK && view.distorts)
    throw CameraError(CameraExit::kBlob,
                      arguments.blob + ": table " + std::to_string(table) +
                          " is an inverse remap (distort); select a table that "
                          "undistorts with --table");
  if (arguments.only_valid) RequireMask(arguments.blob, blob.bytes);
  blob.capture = ReadCapture(arguments.blob, blob.bytes.data(),
                             static_cast<uint32_t>(blob.bytes.size()));
  if (arguments.is_strict && !blob.capture)
    throw CameraError(CameraExit::kBlob,
                      arguments.blob +
                          ": --strict: the blob has no capture settings; pack "
                          "it with --capture-settings");
  return blob;
}

void Run(CameraArguments arguments) {
  if (arguments.is_help) {
    std::fputs(kCameraHelp, stdout);
    return;
  }
  if (arguments.is_list) {
    std::fputs(DescribeCameras().c_str(), stdout);
    return;
  }
  const Blob blob = OpenBlob(arguments);
  if (arguments.width == 0) {
    uint16_t width, height;
    rg_frame_size(&blob.camera, &width, &height);
    arguments.width = width;
    arguments.height = height;
  }
  const bool can_wait = !arguments.recording.empty() && !arguments.is_live;
  if (can_wait || arguments.is_benchmark) arguments.every_frame = true;
  const auto source = OpenFrameSource(arguments);
  if (!source && arguments.is_check) FailCheck();
  if (source)
    RunCameraSession(arguments, blob.camera, blob.capture, source.get());
}

int Main(int argc, char** argv) {
  // The subcommand capture requires no blob: it records the images for the
  // calibration.
  if (argc > 1 && std::string(argv[1]) == "capture")
    return ExecSiblingProgram("raygrid-capture", {argv + 2, argv + argc});
  try {
    InstallSignalHandlers();
    Run(ParseCameraArguments(argc, argv));
    return static_cast<int>(CameraExit::kDone);
  } catch (const CameraError& error) {
    std::fprintf(stderr, "raygrid-camera: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "raygrid-camera: %s\n", error.what());
    return static_cast<int>(CameraExit::kInput);
  }
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) { return raygrid::Main(argc, argv); }
