#ifndef RAYGRID_SIMULATION_SIMULATED_CAMERA_MODELS_H
#define RAYGRID_SIMULATION_SIMULATED_CAMERA_MODELS_H

#include <memory>
#include <string>

#include "camera/operating_point_model.h"

namespace raygrid {

/// Simulated lenses by name, over the image and one pixel around it:
///   pinhole     65 degrees horizontally, almost no distortion
///   example     ExampleSimulatedCamera(), only 640 x 480 px
///   wide        100 degrees, barrel distortion, local bumps
///   fisheye     145 degrees, local bumps
///   fisheye190  190 degrees
///   noncentral  the fisheye, whose pupil moves by 2 mm theta^2
///   glass       62 degrees, barrel distortion, local bumps, the same moving
///               pupil, behind GlassPlate()
///   anamorphic, off-axis, halves, decentred, mirror
///               lenses that no radial model fits within 20 px, see
///               simulation/asymmetric_camera.h
/// Throws InputError for other names and for sizes a lens does not have.
std::unique_ptr<CameraModel> MakeSimulatedCamera(const std::string& name,
                                                 const ImageSize& size);

/// The operating point of a simulated lens.
struct SimulatedOperatingPoint {
  double lens_position = 0;  ///< dioptres, 0 to 10
  double temperature = 20;   ///< degrees Celsius
};

/// A lens that varies with its operating point, 62 degrees with barrel
/// distortion and local bumps, over the image and one pixel around it:
///   lens_position  the focal length increases by 4 % over 10 dioptres, not
///                  quite linearly; principal point and distortion vary with it
///   temperature    the focal length decreases by 40 ppm/K relative to that at
///                  the lens position; the principal point moves by 0.5 px over
///                  50 K, less at high temperatures
std::unique_ptr<CameraModel> MakeVaryingCamera(
    const SimulatedOperatingPoint& state, const ImageSize& size);
/// Returns the lens at a value of one variable, the other as in
/// SimulatedOperatingPoint.
std::unique_ptr<CameraModel> MakeVaryingCamera(OperatingParameter condition,
                                               double value,
                                               const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_CAMERA_MODELS_H
