#ifndef RAYGRID_SIMULATION_SIMULATED_LENSES_H
#define RAYGRID_SIMULATION_SIMULATED_LENSES_H

#include <memory>
#include <string>

#include "camera/camera_stack.h"

namespace raygrid {

/// Known lenses by name, over the image and one pixel around it:
///   pinhole     65 degrees across the image's width, next to no distortion
///   example     ExampleSimulatedCamera(), over 640 x 480 px alone
///   wide        100 degrees, barrel distortion, local bumps
///   fisheye     145 degrees, local bumps
///   fisheye190  190 degrees
///   noncentral  the fisheye, whose pupil moves by 2 mm theta^2
///   glass       62 degrees, barrel distortion, local bumps, the same moving
///               pupil, behind GlassPlate()
///   anamorphic, off-axis, halves, decentred, mirror
///               lenses that no radial lens follows within 20 px, as in
///               simulation/uneven_lens.h
/// Throws InputError for other names and for sizes a lens does not have.
std::unique_ptr<CameraModel> SimulatedLens(const std::string& name,
                                           const ImageSize& size);

/// The conditions that a simulated lens changes with.
struct LensState {
  double lens_position = 0;  ///< dioptres, 0 to 10
  double temperature = 20;   ///< degrees Celsius
};

/// A lens that changes, 62 degrees with barrel distortion and local bumps, over
/// the image and one pixel around it:
///   lens_position  the focal length grows by 4 % over 10 dioptres, not quite
///                  evenly; the centre and the distortion move with it
///   temperature    the focal length shrinks by 40 ppm/K, of what it is at the
///                  lens position; the centre moves by 0.5 px over 50 K, less
///                  the warmer it is
std::unique_ptr<CameraModel> ChangingLens(const LensState& state,
                                          const ImageSize& size);
/// The lens at a value of one condition, with the other as LensState has it.
std::unique_ptr<CameraModel> ChangingLens(CameraCondition condition,
                                          double value, const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_LENSES_H
