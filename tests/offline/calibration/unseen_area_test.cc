// A camera in the part of its image that no feature was seen in, against the
// truth.

#include <algorithm>
#include <cstdio>
#include <map>

#include "calibration/calibration.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {640, 480};
constexpr double kSeenPart = 0.6;  // of the width, in the middle

bool IsSeen(const Eigen::Vector2d& pixel) {
  return std::abs(pixel.x() + 0.5 - kSize.width / 2.0) <=
         kSeenPart * kSize.width / 2;
}

Dataset SeenInTheMiddle(const CameraModel& camera, int num_images) {
  SimulationOptions options;
  options.num_images = num_images;
  Dataset dataset =
      SimulateObservations(camera, FineTestBoard(), options).dataset;
  for (ImageFeatures& image : dataset.images)
    image.features.erase(
        std::remove_if(image.features.begin(), image.features.end(),
                       [](const Feature& f) { return !IsSeen(f.pixel); }),
        image.features.end());
  return dataset;
}

// One image held out saves the time of cross-validation.
CalibrationResult CalibrateModel(const Dataset& dataset,
                                 const std::string& model,
                                 double knot_spacing_px) {
  CalibrationOptions options;
  options.model = model;
  options.knot_spacing_px = knot_spacing_px;
  options.hold_out = {dataset.images.back().image};
  return Calibrate(dataset, FineTestBoard(), options);
}

// The errors beyond the features, by pixel, of what lies within an angle of the
// axis; a pixel of cameras of lines counts by its larger one.
std::map<std::pair<double, double>, double> ComputeExcessErrors(
    const CameraModel& truth, const CameraModel& camera, double max_angle_rad) {
  constexpr double kStepPx = 10;
  const ModelDifference difference = CompareModels(truth, camera, kStepPx);
  std::map<std::pair<double, double>, double> errors;
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    const Eigen::Vector2d& pixel = difference.pixels[i];
    const auto ray = truth.Unproject(pixel);
    if (IsSeen(pixel) || !ray || ray->z() < std::cos(max_angle_rad)) continue;
    double& error = errors[{pixel.x(), pixel.y()}];
    error = std::max(error, difference.error_px[i].norm());
  }
  return errors;
}

// The part of the pixels whose error is within twice the stated deviation.
double PartWithinTwice(
    const std::map<std::pair<double, double>, double>& errors,
    const CameraFile& known) {
  int within = 0;
  for (const auto& [pixel, error] : errors)
    within +=
        error <= 2 * known.uncertainty->lattice.At(known.camera->area(),
                                                   {pixel.first, pixel.second});
  return within / static_cast<double>(errors.size());
}

struct LensCase {
  const char *lens, *model;  // simulated, and of the grid
  int num_images;
  double knot_spacing_px;
};

// No parametric camera is better there, where both answer.
void ExpectGoesOnWell(const LensCase& test, double max_angle_rad = M_PI) {
  const auto truth = MakeSimulatedCamera(test.lens, kSize);
  const Dataset dataset = SeenInTheMiddle(*truth, test.num_images);
  const CalibrationResult grid =
      CalibrateModel(dataset, test.model, test.knot_spacing_px);
  EXPECT_TRUE(grid.camera.camera->area() == WholeImage(kSize));
  const auto errors =
      ComputeExcessErrors(*truth, *grid.camera.camera, max_angle_rad);
  const double part = PartWithinTwice(errors, grid.camera);
  std::printf("%s: %zu pixels, %.0f %% within twice the deviation\n", test.lens,
              errors.size(), 100 * part);
  EXPECT_GT(errors.size(), 600u);
  EXPECT_GE(part, 0.9);
  for (const char* model : {"opencv", "thin-prism-fisheye", "central-radial"}) {
    const CalibrationResult other = CalibrateModel(dataset, model, 0);
    double sum = 0, other_sum = 0;
    int count = 0;
    for (const auto& [pixel, error] :
         ComputeExcessErrors(*truth, *other.camera.camera, max_angle_rad)) {
      const auto found = errors.find(pixel);
      if (found == errors.end()) continue;
      sum += found->second * found->second;
      other_sum += error * error;
      ++count;
    }
    std::printf("  RMS error %.3f px, that of %s %.3f px, %d pixels\n",
                std::sqrt(sum / count), model, std::sqrt(other_sum / count),
                count);
    EXPECT_LE(sum, other_sum) << model;
  }
}

TEST(UnseenArea, GoesOnWellOfAWideLens) {
  ExpectGoesOnWell({"wide", "central-generic", 20, 40});
}

TEST(UnseenArea, GoesOnWellOfAFisheye) {
  constexpr double kHalfView = 95 * M_PI / 180;
  ExpectGoesOnWell({"fisheye190", "central-generic", 30, 40}, kHalfView);
}

TEST(UnseenArea, GoesOnWellOfALensWithBumps) {
  ExpectGoesOnWell({"example", "central-generic", 20, 40});
}

TEST(UnseenArea, GoesOnWellBehindGlass) {
  ExpectGoesOnWell({"glass", "noncentral-generic", 20, 64});
}

TEST(UnseenArea, IsLeftOutWhereFeaturesAreAskedFor) {
  const Dataset dataset =
      SeenInTheMiddle(*MakeSimulatedCamera("example", kSize), 20);
  CalibrationOptions options;
  options.area = AreaChoice::kFeatures;
  options.knot_spacing_px = 80;
  options.hold_out = {dataset.images.back().image};
  const auto camera =
      Calibrate(dataset, FineTestBoard(), options).camera.camera;
  EXPECT_TRUE(IsSeen({camera->area().x0, 240}));
  EXPECT_TRUE(IsSeen({camera->area().x1, 240}));
  EXPECT_FALSE(camera->Unproject({20, 240}));
}

}  // namespace
}  // namespace raygrid
