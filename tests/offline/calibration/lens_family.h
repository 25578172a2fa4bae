#ifndef RAYGRID_TESTS_OFFLINE_CALIBRATION_LENS_FAMILY_H
#define RAYGRID_TESTS_OFFLINE_CALIBRATION_LENS_FAMILY_H

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "simulation/random.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_fisheye.h"

namespace raygrid {

/// Lenses of a kind, drawn at random: a parametric camera whose centre varies,
/// and Gaussian bumps of one radius, distributed evenly over the image and two
/// radii around it, whose displacements are normally distributed.
struct LensFamily {
  ImageSize size;
  double f_px = 0;
  bool is_fisheye = false;  ///< SimulatedFisheye, or else OpenCvModel
  double k1 = 0, k2 = 0;
  int num_bumps = 8;
  double bump_px = 0;  ///< standard deviation of each coordinate
  double radius_px = 1;
};

/// "wide" (77 degrees), "narrow" (71), "fisheye" (145), "fisheye190", "smooth"
/// (65, without bumps).
inline LensFamily LensFamilyOf(const std::string& name) {
  if (name == "wide") return {{640, 480}, 400, false, -0.25, 0.06, 8, 0.7, 70};
  if (name == "narrow")
    return {{1280, 800}, 900, false, -0.08, 0.02, 8, 0.7, 140};
  if (name == "fisheye")
    return {{640, 480}, 260, true, -0.03, 0.002, 8, 0.7, 80};
  if (name == "fisheye190")
    return {{640, 480}, 195, true, -0.03, 0.002, 8, 0.3, 60};
  return {{640, 480}, 500, false, -0.1, 0.02, 0, 0, 1};
}

inline std::vector<DistortionBump> DrawBumps(const LensFamily& family,
                                             Random* random) {
  const double margin = 2 * family.radius_px;
  std::vector<DistortionBump> bumps(family.num_bumps);
  for (DistortionBump& bump : bumps) {
    bump.center.x() = random->Uniform(-margin, family.size.width - 1 + margin);
    bump.center.y() = random->Uniform(-margin, family.size.height - 1 + margin);
    bump.displacement_px.x() = family.bump_px * random->Normal();
    bump.displacement_px.y() = family.bump_px * random->Normal();
    bump.radius_px = family.radius_px;
  }
  return bumps;
}

inline std::unique_ptr<CameraModel> DrawLens(const LensFamily& family,
                                             uint64_t seed) {
  constexpr double kMarginPx = 12;  // more than bumps move a pixel
  constexpr double kCenterPx = 2;   // standard deviation
  Random random(1000 + seed);
  const ImageSize& size = family.size;
  const Area image = {0, 0, size.width - 1.0, size.height - 1.0};
  const Area around = {-kMarginPx, -kMarginPx, image.x1 + kMarginPx,
                       image.y1 + kMarginPx};
  std::vector<DistortionBump> bumps = DrawBumps(family, &random);
  const double cx = size.width * 0.503 - 0.5 + kCenterPx * random.Normal();
  const double cy = size.height * 0.495 - 0.5 + kCenterPx * random.Normal();
  std::shared_ptr<const CameraModel> lens;
  if (family.is_fisheye) {
    FisheyeParameters parameters;
    parameters.f_px = family.f_px;
    parameters.cx = cx;
    parameters.cy = cy;
    parameters.k1 = family.k1;
    parameters.k2 = family.k2;
    parameters.max_theta = 110 * M_PI / 180;
    lens = std::make_shared<SimulatedFisheye>(size, around, parameters);
  } else {
    lens = std::make_shared<OpenCvModel>(
        size, around,
        OpenCvModel::ParameterArray{family.f_px, 1.001 * family.f_px, cx, cy,
                                    family.k1, family.k2, 0, 0, 0, 0, 2e-4,
                                    -1e-4});
  }
  return std::make_unique<SimulatedCamera>(std::move(lens), image,
                                           std::move(bumps));
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_CALIBRATION_LENS_FAMILY_H
