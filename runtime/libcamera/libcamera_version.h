/// What differs between versions of libcamera: Debian 12's 0.0.3 is the oldest
/// that is supported.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_VERSION_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_VERSION_H

#include <libcamera/camera.h>
#include <libcamera/control_ids.h>
#include <libcamera/property_ids.h>
#include <libcamera/version.h>

#include <memory>
#include <optional>

namespace raygrid {

/// From 0.1 on the roles are a span instead of a vector.
inline std::unique_ptr<libcamera::CameraConfiguration> GenerateConfiguration(
    libcamera::Camera* camera, libcamera::StreamRole role) {
  return camera->generateConfiguration({role});
}

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_VERSION_H
