#ifndef RAYGRID_CAMERA_FRAME_SOURCES_H
#define RAYGRID_CAMERA_FRAME_SOURCES_H

#include <memory>
#include <string>

#include "camera_arguments.h"
#include "frame_source.h"

namespace raygrid {

/// The camera, or the recording, that the arguments ask for. Throws
/// CameraError.
std::unique_ptr<FrameSource> OpenFrameSource(const CameraArguments& arguments);

/// All cameras that can be asked for, as text for people.
std::string DescribeCameras();

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_SOURCES_H
