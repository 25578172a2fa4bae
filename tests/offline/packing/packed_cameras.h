#ifndef RAYGRID_TESTS_OFFLINE_PACKING_PACKED_CAMERAS_H
#define RAYGRID_TESTS_OFFLINE_PACKING_PACKED_CAMERAS_H

#include <memory>

#include "packing/blob_camera.h"
#include "packing/pack.h"
#include "packing/view_request.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {

// Fitted once for all tests.
inline const CameraFile& GenericFile() {
  static const CameraFile* const file = [] {
    auto* made = new CameraFile;
    made->camera = std::make_shared<CentralGeneric>(
        FittedGrid(ExampleSimulatedCamera(), 40));
    made->name = "front";
    made->serial = "0042";
    made->training = {0.1, 0.12, 0.9, 3000};
    return made;
  }();
  return *file;
}

// 0 degrees: as sharp as the camera in the middle.
inline VirtualView ViewOf(const CameraModel& camera, const ImageSize& size,
                          double hfov_deg) {
  ViewRequest request;
  request.size = size;
  if (hfov_deg != 0) request.hfov_deg = hfov_deg;
  return MakeView(camera, request);
}

inline VirtualView Virtual() {
  return ViewOf(*GenericFile().camera, {640, 480}, 0);
}

inline PackOptions WithRemap(double max_error_px = 0.05) {
  PackOptions options;
  options.remaps = {Virtual()};
  options.max_error_px = max_error_px;
  return options;
}

inline const PackedCamera& Packed() {
  static const PackedCamera* const packed =
      new PackedCamera(PackCamera(GenericFile(), WithRemap()));
  return *packed;
}

inline const BlobCamera& Opened() {
  static const BlobCamera* const camera =
      new BlobCamera("packed", Packed().blob);
  return *camera;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_PACKING_PACKED_CAMERAS_H
