#ifndef RAYGRID_TESTS_OFFLINE_FLEET_LENS_FAMILY_H
#define RAYGRID_TESTS_OFFLINE_FLEET_LENS_FAMILY_H

#include <algorithm>
#include <vector>

#include "simulation/random.h"
#include "simulation/simulated_camera.h"

namespace raygrid {

/// Standard deviations of that in which lenses of a family differ.
struct FamilyScatter {
  double focal = 0.004;        ///< a part of the focal length
  double centre_px = 0;        ///< in each axis
  double k1 = 0.0025, k2 = 0;  ///< 0.4 % in the corners
  double p = 0;                ///< decentring
  double bumps_px = 0;         ///< of each lens's own
};

/// Lenses of 100 degrees that no model of few parameters follows: all have the
/// bumps of one mould, 640 x 480 px.
class LensFamily {
 public:
  LensFamily(const FamilyScatter& scatter, uint64_t seed)
      : scatter_(scatter), random_(seed) {}

  static SimulatedCamera Mean() { return Make(Parameters(), {}); }

  SimulatedCamera Draw() {
    std::vector<double> p = Parameters();
    const double focal = 1 + scatter_.focal * random_.Normal();
    p[0] *= focal;
    p[1] *= focal;
    p[2] += scatter_.centre_px * random_.Normal();
    p[3] += scatter_.centre_px * random_.Normal();
    p[4] += scatter_.k1 * random_.Normal();
    p[5] += scatter_.k2 * random_.Normal();
    p[10] += scatter_.p * random_.Normal();
    p[11] += scatter_.p * random_.Normal();
    std::vector<DistortionBump> own;
    constexpr int kOwnBumps = 6;
    for (int k = 0; k < kOwnBumps && scatter_.bumps_px > 0; ++k) {
      DistortionBump bump;
      bump.center.x() = random_.Uniform(0, kSize.width);
      bump.center.y() = random_.Uniform(0, kSize.height);
      bump.displacement_px.x() = scatter_.bumps_px * random_.Normal();
      bump.displacement_px.y() = scatter_.bumps_px * random_.Normal();
      bump.radius_px = 80;
      own.push_back(bump);
    }
    return Make(p, own);
  }

  /// The middle with a focal length that is longer by a part.
  static SimulatedCamera Longer(double focal_part) {
    std::vector<double> parameters = Parameters();
    parameters[0] *= 1 + focal_part;
    parameters[1] *= 1 + focal_part;
    return Make(parameters, {});
  }

  /// The middle with a bump.
  static SimulatedCamera Astray(const Eigen::Vector2d& center,
                                const Eigen::Vector2d& displacement_px,
                                double radius_px) {
    return Make(Parameters(), {{center, displacement_px, radius_px}});
  }

 private:
  static constexpr ImageSize kSize = {640, 480};

  static std::vector<double> Parameters() {
    return {332.8, 333.5, 321.4, 237.1, -0.02, 0.005,
            0,     0.18,  0,     0,     2e-4,  -1e-4};
  }

  static SimulatedCamera Make(const std::vector<double>& p,
                              const std::vector<DistortionBump>& own) {
    std::vector<DistortionBump> bumps = {{{147, 120}, {0.9, -0.5}, 90},
                                         {{479, 340}, {-0.7, 1.3}, 110},
                                         {{332, 57}, {0.4, 0.8}, 70},
                                         {{89, 398}, {-1.0, -0.6}, 100},
                                         {{562, 129}, {0.8, 0.4}, 80}};
    bumps.insert(bumps.end(), own.begin(), own.end());
    OpenCvModel::ParameterArray coefficients;
    std::copy(p.begin(), p.end(), coefficients.begin());
    return SimulatedCamera(OpenCvModel(kSize, {-1, -1, 640, 480}, coefficients),
                           bumps);
  }

  FamilyScatter scatter_;
  Random random_;
};

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_FLEET_LENS_FAMILY_H
