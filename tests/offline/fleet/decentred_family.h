#ifndef RAYGRID_TESTS_OFFLINE_FLEET_DECENTRED_FAMILY_H
#define RAYGRID_TESTS_OFFLINE_FLEET_DECENTRED_FAMILY_H

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "simulation/asymmetric_camera.h"
#include "simulation/random.h"

namespace raygrid {

/// A decentred lens of a family: what a place sees, the family's middle sees at
/// place + d(place). Places are in widths of the image.
class DecentredFamilyLens : public DecentredCamera {
 public:
  /// Standard deviations of that in which lenses differ.
  struct Scatter {
    double focal = 0.004;                     ///< a part of the focal length
    double centre = 3.0 / 640;                ///< in each axis
    double radial3 = 0.002, radial5 = 0.001;  ///< of the image's corners
    double tilt = 0.0005;                     ///< likewise, by each axis's tilt
    double bumps = 0.01 / 640;                ///< of each lens's own
  };

  DecentredFamilyLens(const ImageSize& size, const Area& area)
      : DecentredCamera(size, area) {}
  DecentredFamilyLens(const ImageSize& size, const Area& area,
                      const Scatter& scatter, Random* random)
      : DecentredCamera(size, area) {
    const auto two = [&](double deviation) -> Eigen::Vector2d {
      const double x = random->Normal(), y = random->Normal();
      return deviation * Eigen::Vector2d(x, y);
    };
    focal_ = scatter.focal * random->Normal();
    centre_ = two(scatter.centre);
    radial3_ = scatter.radial3 * random->Normal();
    radial5_ = scatter.radial5 * random->Normal();
    tilt_ = two(scatter.tilt);
    constexpr int kBumps = 6;
    for (int k = 0; k < kBumps && scatter.bumps > 0; ++k) {
      const double x = random->Uniform(-0.5, 0.5),
                   y = random->Uniform(-0.5, 0.5) * HeightPart();
      bumps_.push_back({{x, y}, two(scatter.bumps)});
    }
  }
  std::string Name() const override { return "decentred, of a family"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<DecentredFamilyLens>(*this);
  }

 protected:
  Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& place) const override {
    return DecentredCamera::DirectionFromPosition(place + Displacement(place));
  }
  std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const override {
    const auto middle = DecentredCamera::PositionFromDirection(direction);
    constexpr double kFar = 2;
    if (!middle || middle->norm() > kFar) return std::nullopt;
    constexpr int kRounds = 30;  // each leaves a twentieth of the error or less
    Eigen::Vector2d place = *middle;
    for (int round = 0; round < kRounds; ++round)
      place = *middle - Displacement(place);
    if (!((place + Displacement(place) - *middle).norm() < 1e-9))
      return std::nullopt;
    return place;
  }

 private:
  struct Bump {
    Eigen::Vector2d center, displacement;
  };

  double HeightPart() const {
    return static_cast<double>(image_size().height) / image_size().width;
  }
  Eigen::Vector2d Displacement(const Eigen::Vector2d& place) const {
    constexpr double kBumpRadius = 0.12;
    const Eigen::Vector2d to_corner =
        place / std::hypot(0.5, 0.5 * HeightPart());
    const double r2 = to_corner.squaredNorm();
    Eigen::Vector2d moved =
        -focal_ * place - centre_ +
        to_corner * (radial3_ * r2 + radial5_ * r2 * r2 + tilt_.dot(to_corner));
    for (const Bump& bump : bumps_)
      moved +=
          bump.displacement * std::exp(-(place - bump.center).squaredNorm() /
                                       (2 * kBumpRadius * kBumpRadius));
    return moved;
  }

  double focal_ = 0, radial3_ = 0, radial5_ = 0;
  Eigen::Vector2d centre_ = {0, 0}, tilt_ = {0, 0};
  std::vector<Bump> bumps_;
};

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_FLEET_DECENTRED_FAMILY_H
