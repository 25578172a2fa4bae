#ifndef RAYGRID_CAMERA_FRAME_SOURCES_H
#define RAYGRID_CAMERA_FRAME_SOURCES_H

#include <memory>
#include <string>

#include "camera_arguments.h"
#include "frame_source.h"

namespace raygrid {

/// The camera, the recording or the input that the arguments ask for; NULL
/// where a signal comes first. Throws CameraError.
std::unique_ptr<FrameSource> OpenFrameSource(const CameraArguments& arguments);

/// Whether frames come from a file on standard input, all of which can wait.
bool CanFramesWait(const CameraArguments& arguments);

/// All cameras that can be asked for, as text for people.
std::string DescribeCameras();

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_SOURCES_H
