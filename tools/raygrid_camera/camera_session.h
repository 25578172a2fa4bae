#ifndef RAYGRID_CAMERA_CAMERA_SESSION_H
#define RAYGRID_CAMERA_CAMERA_SESSION_H

#include "camera_arguments.h"
#include "frame_source.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// Frames from the source to where the arguments say, until their number is
/// reached, the source ends or a signal comes. Throws CameraError.
/// recorded  how the camera stood while it was calibrated, if the blob says so
void RunCameraSession(const CameraArguments& arguments, const rg_camera& camera,
                      const std::optional<rg_capture_section>& recorded,
                      FrameSource* source);

/// Makes SIGINT and SIGTERM end a session in order; a second one ends the
/// program at once.
void InstallSignalHandlers();
bool IsSignalled();

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_SESSION_H
