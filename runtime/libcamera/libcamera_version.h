/// Compatibility with versions of libcamera: the oldest supported one is 0.0.3
/// (Debian 12); 0.4.0 and 0.7.2 were compiled.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_VERSION_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_VERSION_H

#include <libcamera/camera.h>
#include <libcamera/control_ids.h>
#include <libcamera/property_ids.h>
#include <libcamera/version.h>

#include <memory>
#include <optional>
#include <string>

namespace raygrid {

/// The roles are a span since 0.1, before a vector.
inline std::unique_ptr<libcamera::CameraConfiguration> GenerateConfiguration(
    libcamera::Camera* camera, libcamera::StreamRole role) {
  return camera->generateConfiguration({role});
}

/// The model property is a view of a string since 0.7, before a string.
inline std::optional<std::string> GetModelName(
    const libcamera::Camera& camera) {
  const auto model = camera.properties().get(libcamera::properties::Model);
  if (!model) return std::nullopt;
  return std::string(*model);
}

/// Returns the EXIF orientation of frames. The configuration specifies flips
/// followed by a transposition before 0.2, and the orientation since then.
#if LIBCAMERA_VERSION_MAJOR == 0 && LIBCAMERA_VERSION_MINOR < 2
inline int GetOrientation(const libcamera::CameraConfiguration& configuration) {
  static const int kOrientations[] = {1, 2, 4, 3, 5, 6, 8, 7};
  return kOrientations[static_cast<int>(configuration.transform) & 7];
}
#else
inline int GetOrientation(const libcamera::CameraConfiguration& configuration) {
  return static_cast<int>(configuration.orientation);
}
#endif

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_VERSION_H
