#ifndef RAYGRID_CAMERA_FRAME_SOURCES_H
#define RAYGRID_CAMERA_FRAME_SOURCES_H

#include <memory>
#include <string>

#include "camera_arguments.h"
#include "frame_source.h"

namespace raygrid {

/// Opens the camera, the recording or the input specified by the arguments.
/// NULL if a signal arrives first. Throws CameraError.
std::unique_ptr<FrameSource> OpenFrameSource(const CameraArguments& arguments);

/// Whether frames are read from a file on standard input, so that all can wait.
bool CanFramesWait(const CameraArguments& arguments);

/// Lists all available cameras, as text for users.
std::string DescribeCameras();

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_SOURCES_H
