#include <cmath>
#include <string>
#include <vector>

#include "calibration/operating_point_calibration.h"
#include "dataset/error.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr ImageSize kSweepSize = {640, 480};

// Images of a changing lens, at several values of its condition.
struct Sweep {
  CalibrationInput input;
  ImageOperatingPoints conditions;
};

// Adds images of the lens in a state.
void TakeImages(const SimulatedOperatingPoint& state,
                const OperatingPoint& values, const SimulationOptions& options,
                Sweep* sweep) {
  const auto lens = MakeVaryingCamera(state, kSweepSize);
  for (ImageFeatures& image :
       SimulateObservations(*lens, FineTestBoard(), options).dataset.images) {
    image.image = std::to_string(options.seed) + image.image;
    sweep->conditions.values[image.image] = values;
    sweep->input.dataset.images.push_back(std::move(image));
  }
}

Sweep TakeSweep(OperatingParameter condition, const std::vector<double>& values,
                int images_each) {
  Sweep sweep;
  sweep.conditions.conditions = {condition};
  sweep.input.dataset.image_size = kSweepSize;
  SimulationOptions options;
  options.num_images = images_each;
  options.noise_px = 0.05;
  for (const double value : values) {
    options.seed = sweep.conditions.values.size() + 1;
    SimulatedOperatingPoint state;
    (condition == OperatingParameter::kLensPosition ? state.lens_position
                                                    : state.temperature) =
        value;
    TakeImages(state, {value}, options, &sweep);
  }
  return sweep;
}

// Images at 8 lens positions, each at a temperature of its own.
Sweep TakeSweepOfBoth(int images_each, uint64_t seed) {
  Sweep sweep;
  sweep.conditions.conditions = {OperatingParameter::kLensPosition,
                                 OperatingParameter::kTemperature};
  sweep.input.dataset.image_size = kSweepSize;
  SimulationOptions options;
  options.num_images = 1;
  options.noise_px = 0.05;
  TestRandom random(seed);
  for (const double position : {0.0, 1.5, 3.0, 4.5, 6.0, 7.5, 9.0, 10.0})
    for (int k = 0; k < images_each; ++k) {
      const SimulatedOperatingPoint state = {position, random.Uniform(20, 70)};
      options.seed = 1000 * seed + sweep.conditions.values.size();
      TakeImages(state, {state.lens_position, state.temperature}, options,
                 &sweep);
    }
  return sweep;
}

// One image held out saves the time of cross-validation, and points that are
// known that of adjusting them.
CalibrationOptions WithCellsOf40(const Dataset& dataset) {
  CalibrationOptions options;
  options.num_threads = 2;
  options.knot_spacing_px = 40;
  options.fix_target_geometry = true;
  options.hold_out = {dataset.images.back().image};
  return options;
}

OperatingPointCalibration CalibrateSweep(const Sweep& sweep) {
  return CalibrateOperatingPoints(sweep.input, sweep.conditions,
                                  FineTestBoard(),
                                  WithCellsOf40(sweep.input.dataset))
      .cameras[0]
      .camera.stack.value();
}

double ErrorPx(const OperatingPointCalibration& stack, double value) {
  return CompareModels(*MakeVaryingCamera(stack.cameras.ranges()[0].condition,
                                          value, kSweepSize),
                       stack.cameras.At({value}), 20)
      .rms_px;
}

double ErrorPx(const OperatingPointCalibration& stack,
               const SimulatedOperatingPoint& state) {
  return CompareModels(
             *MakeVaryingCamera(state, kSweepSize),
             stack.cameras.At({state.lens_position, state.temperature}), 20)
      .rms_px;
}

// The mean of a lattice's squares.
double MeanSquare(const UncertaintyLattice& lattice) {
  double sum = 0;
  for (const double deviation : lattice.stddev_px) sum += deviation * deviation;
  return sum / static_cast<double>(lattice.stddev_px.size());
}

TEST(CalibrateOperatingPoints, TellsTheCameraAtLensPositionsThatNoImageHas) {
  const OperatingPointCalibration stack = CalibrateSweep(TakeSweep(
      OperatingParameter::kLensPosition, {0, 1.5, 3, 4.5, 6, 7.5, 9, 10}, 12));
  EXPECT_EQ(stack.cameras.ranges()[0].low, 0);
  EXPECT_EQ(stack.cameras.ranges()[0].high, 10);
  EXPECT_GE(stack.cameras.orders()[0], 2);
  for (const double value : {0.7, 2.2, 5.2, 8.3, 9.5})
    EXPECT_LT(ErrorPx(stack, value), 0.03) << value;
  // A deviation is that of the worse of two directions, and errors are smooth:
  // one draw of them is far from their mean square.
  ASSERT_EQ(stack.deviations.size(), 5u);
  double stated = 0, found = 0;
  for (const OperatingPointUncertainty& at : stack.deviations) {
    stated += MeanSquare(at.lattice);
    found += std::pow(ErrorPx(stack, at.values[0]), 2);
  }
  EXPECT_GT(found, 0.4 * stated);
  EXPECT_LT(found, 4 * stated);
}

// The verdict's word and reasons.
std::string VerdictOf(const Sweep& sweep) {
  const Assessment assessment =
      CalibrateOperatingPoints(sweep.input, sweep.conditions, FineTestBoard(),
                               WithCellsOf40(sweep.input.dataset))
          .cameras[0]
          .assessment;
  std::string text = assessment.word;
  for (const std::string& reason : assessment.reasons) text += "; " + reason;
  return text;
}

int ReadCountInRange(const std::string& text, const std::string& part) {
  int count = 0;
  for (size_t at = text.find(part); at != std::string::npos;
       at = text.find(part, at + 1))
    ++count;
  return count;
}

// The value that an image's features fit, as the verdict says it.
double PredictedIn(const std::string& assessment, const std::string& image) {
  const std::string before = "but its features indicate ";
  const size_t at =
      assessment.find(before, assessment.find(image + " is specified as"));
  return at == std::string::npos
             ? NAN
             : std::stod(assessment.substr(at + before.size()));
}

// The board's distance takes up most of what a wrong focal length does: the
// residuals stay small, and the camera is wrong.
TEST(CalibrateOperatingPoints, NamesImagesWhoseValuesDoNotFit) {
  Sweep sweep =
      TakeSweep(OperatingParameter::kLensPosition, {0, 2, 4, 6, 8, 10}, 6);
  const std::string right = VerdictOf(sweep);
  EXPECT_EQ(ReadCountInRange(right, "is specified as"), 0) << right;
  EXPECT_EQ(ReadCountInRange(right, "does not explain"), 0) << right;
  // One image with a wrong value, and two with swapped values.
  const auto& images = sweep.input.dataset.images;
  const std::string wrong = images[15].image, first = images[8].image,
                    second = images[27].image;
  ASSERT_EQ(sweep.conditions.values.at(wrong).front(), 4);
  sweep.conditions.values.at(wrong).front() = 9;
  sweep.conditions.values.at(first).front() = 8;
  sweep.conditions.values.at(second).front() = 2;
  const std::string assessment = VerdictOf(sweep);
  EXPECT_EQ(assessment.find("warn"), 0u);
  EXPECT_NEAR(PredictedIn(assessment, wrong), 4, 0.6) << assessment;
  EXPECT_NEAR(PredictedIn(assessment, first), 2, 0.6) << assessment;
  EXPECT_NEAR(PredictedIn(assessment, second), 8, 0.6) << assessment;
  // No other image is blamed for it.
  EXPECT_EQ(ReadCountInRange(assessment, "is specified as"), 3) << assessment;
}

TEST(CalibrateOperatingPoints, SaysThatShuffledValuesDoNotExplainTheImages) {
  Sweep sweep =
      TakeSweep(OperatingParameter::kLensPosition, {0, 2, 4, 6, 8, 10}, 4);
  std::vector<double> values;
  for (const ImageFeatures& image : sweep.input.dataset.images)
    values.push_back(sweep.conditions.values.at(image.image).front());
  TestRandom random(3);
  for (size_t i = values.size(); i > 1; --i)
    std::swap(values[i - 1], values[random.Index(static_cast<int>(i))]);
  for (size_t i = 0; i < values.size(); ++i)
    sweep.conditions.values.at(sweep.input.dataset.images[i].image) = {
        values[i]};
  const std::string assessment = VerdictOf(sweep);
  EXPECT_EQ(ReadCountInRange(assessment,
                             "the specified lens_position does not explain"),
            1)
      << assessment;
  EXPECT_EQ(ReadCountInRange(assessment, "is specified as"), 0) << assessment;
  EXPECT_EQ(ReadCountInRange(assessment, "bends"), 0) << assessment;
}

// Two positions fit any line: in the middle, rays may be as wrong as they like.
TEST(CalibrateOperatingPoints, WarnsWhereNoImageShowsTheErrorBetweenValues) {
  const auto warns = [](const std::vector<double>& positions) {
    const Sweep sweep =
        TakeSweep(OperatingParameter::kLensPosition, positions, 8);
    const Assessment assessment =
        CalibrateOperatingPoints(sweep.input, sweep.conditions, FineTestBoard(),
                                 WithCellsOf40(sweep.input.dataset))
            .assessment;
    for (const std::string& reason : assessment.reasons)
      if (reason.find("interpolates these values of lens_position") !=
          std::string::npos) {
        EXPECT_NE(assessment.word, "pass");
        EXPECT_NE(reason.find("as at 5 dioptres"), std::string::npos) << reason;
        return true;
      }
    return false;
  };
  EXPECT_TRUE(warns({0, 10}));
  // A driver tells each image a value that is a little different.
  EXPECT_TRUE(warns({0, 0.1, 9.9, 10}));
  EXPECT_FALSE(warns({0, 3, 7, 10}));
}

TEST(CalibrateOperatingPoints, FollowsACameraThatWarms) {
  const OperatingPointCalibration stack = CalibrateSweep(
      TakeSweep(OperatingParameter::kTemperature, {20, 32, 45, 58, 70}, 6));
  EXPECT_EQ(stack.cameras.orders()[0], 1);
  EXPECT_LT(ErrorPx(stack, 26), 0.03);
  EXPECT_LT(ErrorPx(stack, 65), 0.03);
  // A camera that does not change is wrong by half of this, at least.
  const auto cold =
      MakeVaryingCamera(OperatingParameter::kTemperature, 26, kSweepSize);
  const auto warm =
      MakeVaryingCamera(OperatingParameter::kTemperature, 65, kSweepSize);
  EXPECT_GT(CompareModels(*cold, *warm, 20).rms_px, 0.2);
}

// Pairs of values that no image has. The lens's focal length is a product of
// both changes, and the stack a sum.
TEST(CalibrateOperatingPoints,
     TellsTheCameraAtPairsOfConditionsThatNoImageHas) {
  const OperatingPointCalibration stack =
      CalibrateSweep(TakeSweepOfBoth(12, 1));
  ASSERT_EQ(stack.cameras.ranges().size(), 2u);
  EXPECT_EQ(stack.cameras.ranges()[0].condition,
            OperatingParameter::kLensPosition);
  EXPECT_EQ(stack.cameras.ranges()[0].high, 10);
  EXPECT_GE(stack.cameras.orders()[0], 2);
  EXPECT_EQ(stack.cameras.orders()[1], 1);
  for (const SimulatedOperatingPoint& state :
       {SimulatedOperatingPoint{0.7, 60}, SimulatedOperatingPoint{2.2, 30},
        SimulatedOperatingPoint{5.2, 45}, SimulatedOperatingPoint{8.3, 62},
        SimulatedOperatingPoint{9.5, 25}})
    EXPECT_LT(ErrorPx(stack, state), 0.03)
        << state.lens_position << " " << state.temperature;
  // A camera over the lens position alone is wrong by the temperature.
  EXPECT_GT(
      CompareModels(
          *MakeVaryingCamera(SimulatedOperatingPoint{2.2, 30}, kSweepSize),
          *MakeVaryingCamera(SimulatedOperatingPoint{2.2, 45}, kSweepSize), 20)
          .rms_px,
      0.1);
  ASSERT_EQ(stack.deviations.size(), 15u);
  EXPECT_EQ(stack.deviations.front().values[0], 0);
  EXPECT_EQ(stack.deviations.back().values[0], 10);
}

TEST(CalibrateOperatingPoints, RefusesConditionsThatGoTogether) {
  Sweep sweep = TakeSweepOfBoth(2, 1);
  for (auto& [image, values] : sweep.conditions.values)
    values[1] = 20 + 4 * values[0];
  ExpectError(ExitCode::kUsage,
              {"lens_position and temperature of the images are correlated"},
              [&] { CalibrateSweep(sweep); });
}

TEST(CalibrateOperatingPoints, RefusesImagesThatTellNoChange) {
  Sweep sweep = TakeSweep(OperatingParameter::kLensPosition, {3}, 5);
  const auto message = [&] {
    try {
      CalibrateSweep(sweep);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message().find("all images have the same lens_position"),
            std::string::npos);
  sweep.conditions.values.erase(sweep.input.dataset.images[2].image);
  EXPECT_NE(message().find("has no lens_position"), std::string::npos);
}

TEST(CalibrateOperatingPoints, RefusesAnImageAtTwoValues) {
  Sweep sweep = TakeSweep(OperatingParameter::kLensPosition, {0, 5, 10}, 3);
  std::vector<ImageFeatures>& images = sweep.input.dataset.images;
  images.back().features = images.front().features;
  ExpectError(ExitCode::kInvalidInput,
              {images.front().image, images.back().image, "0 and 10"},
              [&] { CalibrateSweep(sweep); });
}

TEST(MaxPolynomialOrder, LeavesValuesToTestWith) {
  EXPECT_EQ(MaxPolynomialOrder(2), 1);
  EXPECT_EQ(MaxPolynomialOrder(3), 2);
  EXPECT_EQ(MaxPolynomialOrder(4), 2);
  EXPECT_EQ(MaxPolynomialOrder(5), 3);
  EXPECT_EQ(MaxPolynomialOrder(50), 3);
}

}  // namespace
}  // namespace raygrid
