/// A camera file with a grid, and what may be known of its camera.
#ifndef RAYGRID_TESTS_OFFLINE_DATASET_EXAMPLE_CAMERA_FILE_H
#define RAYGRID_TESTS_OFFLINE_DATASET_EXAMPLE_CAMERA_FILE_H

#include <cmath>
#include <memory>

#include "dataset/camera_file.h"
#include "simulation/simulated_camera.h"

namespace raygrid {

inline CameraFile GridFile() {
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(FitCentralGeneric(
      ExampleSimulatedCamera(), {1.0 / 3, 2, 630.1, 470}, 7, 6));
  file.name = "left: \"front\" # 2 \\ é";
  file.serial = "0042";
  file.training = {0.1, 0.12, 0.9, 3000};
  file.held_out = {0.11, 0.13, 1.9, 2900};
  return file;
}

inline CameraUncertainty ExampleUncertainty() {
  CameraUncertainty uncertainty;
  uncertainty.lattice = {3, 2, {0.01, 0.02, 0.03, 0.04, NAN, 0.25}};
  uncertainty.mask = ValidityMask::Over({640, 480});
  for (size_t k = 0; k < uncertainty.mask.is_valid.size(); k += 3)
    uncertainty.mask.is_valid[k] = true;
  uncertainty.max_stddev_px = 0.025;
  uncertainty.modes = {2,
                       2,
                       {{{0.01, 0.02}, {0.03, 0}, {-0.5, 0}, {0, 0.125}}},
                       0.004,
                       {0.001, 0.375, 0.0005, 0.03}};
  return uncertainty;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_DATASET_EXAMPLE_CAMERA_FILE_H
