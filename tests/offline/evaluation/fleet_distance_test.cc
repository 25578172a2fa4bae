#include "evaluation/fleet_distance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "camera/lens_displacements.h"
#include "camera/rotated_camera.h"
#include "fleet/lens_family.h"
#include "simulation/simulated_camera_models.h"

namespace raygrid {
namespace {

constexpr double kFocalScatter = 0.004;

// A fleet whose focal lengths alone differ.
PopulationCovariance SpreadOfFocalLengths() {
  PopulationCovariance spread;
  spread.columns = 17;
  spread.rows = 13;
  const SimulatedCamera mean = LensFamily::Mean();
  auto& field = spread.displacements_px.emplace_back();
  for (const auto& displacement :
       ComputeDisplacements(mean, LensFamily::Longer(kFocalScatter),
                            spread.GetPositions(mean.area())))
    field.push_back(displacement.value());
  return spread;
}

// The features' pixels in a part of the image.
std::vector<Eigen::Vector2d> PixelsIn(const Area& part) {
  constexpr double kStepPx = 16;
  std::vector<Eigen::Vector2d> pixels;
  for (double y = part.y0; y <= part.y1; y += kStepPx)
    for (double x = part.x0; x <= part.x1; x += kStepPx)
      pixels.emplace_back(x, y);
  return pixels;
}

const Area kWhole = {0, 0, 639, 479}, kCorner = {330, 250, 630, 470};

FleetDistance DistanceOf(const CameraModel& camera, const Area& part = kWhole,
                         const UncertaintyLattice* deviations = nullptr) {
  return MeasureFleetDistance(LensFamily::Mean(), SpreadOfFocalLengths(),
                              camera, deviations, PixelsIn(part))
      .value();
}

TEST(FleetDistance, CountsInWhatUnitsDiffer) {
  for (const double times : {-2.5, 0.5, 1.0, 4.0}) {
    const FleetDistance distance =
        DistanceOf(LensFamily::Longer(times * kFocalScatter));
    EXPECT_NEAR(distance.rms_px / distance.units_px, std::abs(times),
                0.05 * std::abs(times));
    EXPECT_FALSE(distance.IsOutlier()) << times;
  }
  EXPECT_TRUE(DistanceOf(LensFamily::Longer(6 * kFocalScatter)).IsOutlier());
}

// A part of the image lies to one side of the axis, where a focal length mostly
// does what a turn does: the turn is that of the part.
TEST(FleetDistance, IsThatWhereFeaturesAre) {
  const SimulatedCamera longer = LensFamily::Longer(2 * kFocalScatter);
  const FleetDistance corner = DistanceOf(longer, kCorner);
  EXPECT_NEAR(corner.rms_px / corner.units_px, 2, 0.1);
  EXPECT_LT(corner.units_px, 0.6 * DistanceOf(longer).units_px);
}

TEST(FleetDistance, KnowsNoTurns) {
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, -2, 3).normalized()));
  const SimulatedCamera longer = LensFamily::Longer(3 * kFocalScatter);
  EXPECT_NEAR(DistanceOf(RotatedCamera(longer, turn), kCorner).rms_px,
              DistanceOf(longer, kCorner).rms_px, 1e-6);
}

TEST(FleetDistance, CountsWhatACameraStatesOfItself) {
  const double units_px = DistanceOf(LensFamily::Mean()).units_px;
  const UncertaintyLattice stated = {2, 2, {3, 3, 3, 3}};
  EXPECT_NEAR(DistanceOf(LensFamily::Mean(), kWhole, &stated).units_px,
              std::hypot(units_px, 3 * std::sqrt(2)), 1e-6);
}

// Half of what a fisheye sees lies far beyond the middle's image.
TEST(FleetDistance, IsLargeWhereTheMiddleSeesNothing) {
  const FleetDistance distance =
      DistanceOf(*MakeSimulatedCamera("fisheye190", {640, 480}));
  EXPECT_GT(distance.rms_px, 20);
  EXPECT_TRUE(distance.IsOutlier());
  EXPECT_NE(distance.Warning().find("calibrate it without"), std::string::npos);
}

TEST(FleetDistance, IsNoneBesideTheMiddlesArea) {
  EXPECT_FALSE(MeasureFleetDistance(LensFamily::Mean(), SpreadOfFocalLengths(),
                                    LensFamily::Mean(), nullptr, {{700, 9}}));
}

// Cameras that agree to what no one sees are of one kind.
TEST(FleetDistance, SaysNothingOfSmallDifferences) {
  EXPECT_FALSE((FleetDistance{0.09, 0.001}).IsOutlier());
  EXPECT_TRUE((FleetDistance{0.11, 0.001}).IsOutlier());
}

}  // namespace
}  // namespace raygrid
