// Images that were turned, mirrored or resized after they were taken.

#include "calibration/image_transforms.h"

#include <set>
#include <string>

#include "calibration/calibration.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {640, 480};

Dataset Observed(const char* lens, int num_images, uint64_t seed) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = 100;
  options.seed = seed;
  return SimulateObservations(*SimulatedLens(lens, kSize), TestBoard(), options)
      .dataset;
}

// Every third image, or every second one, changed; their names.
std::set<std::string> Change(const ImageTransform& transform, size_t step,
                             Dataset* dataset) {
  std::set<std::string> names;
  for (size_t i = 1; i < dataset->images.size(); i += step) {
    names.insert(dataset->images[i].image);
    for (Feature& feature : dataset->images[i].features) {
      // Turns by 180° and mirrorings are their own inverses.
      const Eigen::Vector2d corner(0.5, 0.5);
      feature.pixel =
          transform.scale != 1
              ? Eigen::Vector2d((feature.pixel + corner) * transform.scale -
                                corner)
              : transform.Undo(feature.pixel, kSize);
    }
  }
  return names;
}

CalibrationResult GridOf(const Dataset& dataset) {
  CalibrationOptions options;
  options.cell_px = 80;
  options.flat_board = true;
  options.hold_out = {dataset.images.front().image};
  return Calibrate(dataset, TestBoard(), options);
}

std::set<std::string> RejectedFor(const CalibrationResult& result,
                                  const std::string& reason) {
  std::set<std::string> names;
  for (const RejectedImage& image : result.rejected_images)
    if (image.reason.find(reason) != std::string::npos)
      names.insert(image.image);
  return names;
}

bool Says(const CalibrationResult& result, const std::string& text) {
  for (const std::string& reason : result.verdict.reasons)
    if (reason.find(text) != std::string::npos) return true;
  return false;
}

TEST(ImageTransforms, AreUndoneByTheirInverse) {
  const ImageTransform quarter = {false, 1, 1};
  // The upper right corner was the upper left one.
  const ImageSize square = {100, 100};
  EXPECT_LT((quarter.Undo({99, 0}, square) - Eigen::Vector2d(0, 0)).norm(),
            1e-12);
  const ImageTransform half = {false, 0, 0.5};
  EXPECT_LT((half.Undo({0, 0}, kSize) - Eigen::Vector2d(0.5, 0.5)).norm(),
            1e-12);
  const ImageTransform flip = {true, 2, 1};
  EXPECT_LT((flip.Undo({10, 0}, kSize) - Eigen::Vector2d(10, 479)).norm(),
            1e-12);
}

// The principal point is between that of both kinds, residuals are small, and
// the camera is wrong. Found early, they are left out; else the verdict fails.
TEST(ImageTransforms, TurnedAndMirroredImagesAreNamed) {
  const ImageTransform transforms[] = {{false, 2, 1}, {true, 0, 1}};
  for (const ImageTransform& transform : transforms) {
    Dataset dataset = Observed("fisheye", 21, 1);
    const std::set<std::string> changed = Change(transform, 3, &dataset);
    const CalibrationResult result = GridOf(dataset);
    EXPECT_TRUE(Says(result, transform.Text())) << transform.Text();
    const std::set<std::string> left_out =
        RejectedFor(result, transform.Text());
    if (left_out.empty()) {
      EXPECT_EQ(result.verdict.word, "fail");
      continue;
    }
    for (const std::string& image : changed)
      EXPECT_EQ(left_out.count(image), 1u) << image;
    EXPECT_LE(left_out.size(), changed.size() + 1);
    EXPECT_LT(result.camera.training->median_px, 0.065);
  }
}

// Nothing says which half is as it was taken.
TEST(ImageTransforms, FailWhereHalfOfTheImagesAreMirrored) {
  Dataset dataset = Observed("fisheye", 20, 2);
  Change({true, 0, 1}, 2, &dataset);
  const CalibrationResult result = GridOf(dataset);
  EXPECT_EQ(result.verdict.word, "fail");
  EXPECT_TRUE(Says(result, "mirrored left to right"));
}

// A lens with local distortion leaves errors to any parametric model, which
// hide the turn.
TEST(ImageTransforms, AreNamedInALensWithBumps) {
  Dataset dataset = Observed("example", 24, 4);
  const std::set<std::string> changed = Change({false, 2, 1}, 4, &dataset);
  const CalibrationResult result = GridOf(dataset);
  EXPECT_TRUE(Says(result, "rotated by 180°"));
  EXPECT_EQ(result.verdict.word, "fail");
}

TEST(ImageTransforms, ResizedImagesAreLeftOut) {
  for (const double scale : {0.5, 2.0 / 3}) {
    Dataset dataset = Observed("wide", 20, 3);
    const std::set<std::string> changed =
        Change({false, 0, scale}, 3, &dataset);
    const CalibrationResult result = GridOf(dataset);
    EXPECT_EQ(RejectedFor(result, "scaled by"), changed);
    EXPECT_TRUE(Says(result, "images of one size"));
    EXPECT_FALSE(Says(result, "row time"));
  }
}

TEST(ImageTransforms, AreNotSeenWhereThereAreNone) {
  for (const char* lens : {"fisheye", "wide", "example", "off-axis"}) {
    const CalibrationResult result = GridOf(Observed(lens, 16, 5));
    EXPECT_TRUE(RejectedFor(result, "relative to the others").empty()) << lens;
    EXPECT_FALSE(Says(result, "relative to the others")) << lens;
  }
}

}  // namespace
}  // namespace raygrid
