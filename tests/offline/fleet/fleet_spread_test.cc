#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "calibration/calibration.h"
#include "camera/lens_displacements.h"
#include "decentred_family.h"
#include "evaluation/model_difference.h"
#include "fleet/fleet_mean.h"
#include "fleet/population_estimation.h"
#include "lens_family.h"
#include "simulation/random.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr ImageSize kUnitSize = {640, 480};
constexpr Area kUnitArea = {-1, -1, 640, 480};
constexpr double kFocalPart = 0.004;

CameraFile UnitFile(const CameraModel& lens) {
  CameraFile file;
  file.camera = lens.Clone();
  return file;
}

// Units whose focal lengths alone differ.
std::vector<CameraFile> LongerAndShorter(int count) {
  Random random(3);
  std::vector<CameraFile> files;
  for (int u = 0; u < count; ++u)
    files.push_back(UnitFile(LensFamily::Longer(kFocalPart * random.Normal())));
  return files;
}

// The mean square of a displacement over the lattice.
double RmsPx(const std::vector<Eigen::Vector2d>& field) {
  double sum = 0;
  for (const Eigen::Vector2d& displacement : field)
    sum += displacement.squaredNorm() / static_cast<double>(field.size());
  return std::sqrt(sum);
}

// Far below that come the curvature of what a focal length does, and what
// polynomials leave of bumps.
TEST(EstimatePopulationCovariance, IsOneDirectionIfOneFigureDiffers) {
  const auto spread =
      EstimatePopulationCovariance(LensFamily::Mean(), LongerAndShorter(60));
  ASSERT_TRUE(spread.has_value());
  const auto& fields = spread->displacements_px;
  ASSERT_GE(fields.size(), 1u);
  const double first_px = RmsPx(fields[0]);
  // Places are 240 px from the centre in the mean square.
  EXPECT_NEAR(first_px, kFocalPart * 240, 0.3);
  if (fields.size() > 1) {
    EXPECT_LT(RmsPx(fields[1]), 0.02 * first_px);
  }
}

// Units whose files say that they are wrong by a part of how they differ, which
// comes off: but of a further unit's variance, which is (n + 1) / (n - 1) of
// what is found, and with a n-th of it for the middle's errors.
TEST(EstimatePopulationCovariance, IsLessWhatFilesSay) {
  constexpr int kCount = 60;
  const SimulatedCamera mean = LensFamily::Mean();
  std::vector<CameraFile> units = LongerAndShorter(kCount);
  const auto all = EstimatePopulationCovariance(mean, units);
  ASSERT_TRUE(all.has_value());
  CameraUncertainty stated;
  stated.modes.columns = all->columns;
  stated.modes.rows = all->rows;
  // More than focal lengths do in the second order.
  stated.modes.residual_px = 0.1;
  auto& mode = stated.modes.displacements_px.emplace_back();
  for (const auto& displacement :
       ComputeDisplacements(mean, LensFamily::Longer(0.7 * kFocalPart),
                            all->GetPositions(mean.area())))
    mode.push_back(displacement.value());
  for (CameraFile& unit : units) unit.uncertainty = stated;
  const auto left = EstimatePopulationCovariance(mean, units);
  ASSERT_TRUE(left.has_value());
  constexpr double kComesOff = (kCount + 1.0) / (kCount - 1) - 1.0 / kCount;
  const double expected_px =
      std::sqrt(std::pow(RmsPx(all->displacements_px[0]), 2) -
                kComesOff * std::pow(RmsPx(mode), 2));
  EXPECT_NEAR(RmsPx(left->displacements_px[0]), expected_px,
              0.03 * expected_px);
}

TEST(EstimatePopulationCovariance, IsNoneOfFewUnits) {
  EXPECT_FALSE(
      EstimatePopulationCovariance(LensFamily::Mean(), LongerAndShorter(7)));
}

double P99Of(const CameraModel& lens, const CameraFile& mean,
             std::shared_ptr<const PopulationCovariance> spread) {
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  SimulationOptions simulation;
  simulation.num_images = 6;
  simulation.features_per_image = 120;
  simulation.seed = 11;
  const Dataset dataset =
      SimulateObservations(lens, pattern, simulation).dataset;
  CalibrationOptions options;
  options.like = mean.camera;
  options.prior_population = std::move(spread);
  options.hold_out = {dataset.images.back().image};
  options.knot_spacing_px = kUnitSize.width / 8.0;
  const CameraFile camera = Calibrate(dataset, pattern, options).camera;
  constexpr double kComparedPx = 10;
  return CompareModels(lens, *camera.camera, kComparedPx).p99_px;
}

// Five images tell what differs; the rest is as it is in the fleet.
TEST(EstimatePopulationCovariance, ServesAUnitOfFewImages) {
  Random random(5);
  std::vector<CameraFile> units;
  for (int u = 0; u < 30; ++u)
    units.push_back(
        UnitFile(DecentredFamilyLens(kUnitSize, kUnitArea, {}, &random)));
  const auto mean = ComputeMeanCamera(units);
  ASSERT_TRUE(mean && mean->spread);
  const DecentredFamilyLens unit(kUnitSize, kUnitArea, {}, &random);
  const double with_spread =
      P99Of(unit, *mean, std::make_shared<PopulationCovariance>(*mean->spread));
  EXPECT_LT(with_spread, 0.7 * P99Of(unit, *mean, nullptr));
}

}  // namespace
}  // namespace raygrid
