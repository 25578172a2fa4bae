#ifndef RAYGRID_CAMERA_CAMERA_SESSION_H
#define RAYGRID_CAMERA_CAMERA_SESSION_H

#include "camera_arguments.h"
#include "frame_source.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// Undistorts frames of the source to the outputs in the arguments, until their
/// number is reached, the source ends or a signal arrives. Throws CameraError.
/// recorded  capture settings of the calibration, if the blob has them
void RunCameraSession(const CameraArguments& arguments, const rg_camera& camera,
                      const std::optional<rg_capture_section>& recorded,
                      FrameSource* source);

/// Makes SIGINT and SIGTERM end a session regularly; a second signal ends the
/// program immediately.
void InstallSignalHandlers();
bool IsSignalled();

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_SESSION_H
