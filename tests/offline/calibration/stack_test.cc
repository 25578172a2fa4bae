#include <cmath>
#include <string>
#include <vector>

#include "calibration/stack_calibration.h"
#include "dataset/error.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr ImageSize kSweepSize = {640, 480};

// Images of a changing lens, at several values of its condition.
struct Sweep {
  CalibrationInput input;
  ImageConditions conditions;
};

Sweep TakeSweep(CameraCondition condition, const std::vector<double>& values,
                int images_each) {
  Sweep sweep;
  sweep.conditions.condition = condition;
  sweep.input.dataset.image_size = kSweepSize;
  SimulationOptions options;
  options.num_images = images_each;
  options.noise_px = 0.05;
  for (const double value : values) {
    options.seed = sweep.conditions.values.size() + 1;
    const auto lens = ChangingLens(condition, value, kSweepSize);
    for (ImageFeatures& image :
         SimulateObservations(*lens, FineTestBoard(), options).dataset.images) {
      image.image = std::to_string(value) + image.image;
      sweep.conditions.values[image.image] = value;
      sweep.input.dataset.images.push_back(std::move(image));
    }
  }
  return sweep;
}

// One image held out saves the time of cross-validation, and points that are
// known that of adjusting them.
CalibrationOptions WithCellsOf40(const Dataset& dataset) {
  CalibrationOptions options;
  options.num_threads = 2;
  options.cell_px = 40;
  options.flat_board = true;
  options.hold_out = {dataset.images.back().image};
  return options;
}

StackOfCameras CalibrateSweep(const Sweep& sweep) {
  return CalibrateStack(sweep.input, sweep.conditions, FineTestBoard(),
                        WithCellsOf40(sweep.input.dataset))
      .cameras[0]
      .camera.stack.value();
}

double ErrorPx(const StackOfCameras& stack, double value) {
  return CompareModels(
             *ChangingLens(stack.cameras.condition(), value, kSweepSize),
             stack.cameras.At(value), 20)
      .rms_px;
}

// The mean of a lattice's squares.
double MeanSquare(const DeviationLattice& lattice) {
  double sum = 0;
  for (const double deviation : lattice.deviation_px)
    sum += deviation * deviation;
  return sum / static_cast<double>(lattice.deviation_px.size());
}

TEST(CalibrateStack, TellsTheCameraAtLensPositionsThatNoImageHas) {
  const StackOfCameras stack = CalibrateSweep(TakeSweep(
      CameraCondition::kLensPosition, {0, 1.5, 3, 4.5, 6, 7.5, 9, 10}, 12));
  EXPECT_EQ(stack.cameras.low(), 0);
  EXPECT_EQ(stack.cameras.high(), 10);
  EXPECT_GE(stack.cameras.order(), 2);
  for (const double value : {0.7, 2.2, 5.2, 8.3, 9.5})
    EXPECT_LT(ErrorPx(stack, value), 0.03) << value;
  // A deviation is that of the worse of two directions, and errors are smooth:
  // one draw of them is far from their mean square.
  ASSERT_EQ(stack.deviations.size(), 5u);
  double stated = 0, found = 0;
  for (const StackDeviation& at : stack.deviations) {
    stated += MeanSquare(at.lattice);
    found += std::pow(ErrorPx(stack, at.value), 2);
  }
  EXPECT_GT(found, 0.4 * stated);
  EXPECT_LT(found, 4 * stated);
}

TEST(CalibrateStack, FollowsACameraThatWarms) {
  const StackOfCameras stack = CalibrateSweep(
      TakeSweep(CameraCondition::kTemperature, {20, 32, 45, 58, 70}, 6));
  EXPECT_EQ(stack.cameras.order(), 1);
  EXPECT_LT(ErrorPx(stack, 26), 0.03);
  EXPECT_LT(ErrorPx(stack, 65), 0.03);
  // A camera that does not change is wrong by half of this, at least.
  const auto cold = ChangingLens(CameraCondition::kTemperature, 26, kSweepSize);
  const auto warm = ChangingLens(CameraCondition::kTemperature, 65, kSweepSize);
  EXPECT_GT(CompareModels(*cold, *warm, 20).rms_px, 0.2);
}

TEST(CalibrateStack, RefusesImagesThatTellNoChange) {
  Sweep sweep = TakeSweep(CameraCondition::kLensPosition, {3}, 5);
  const auto message = [&] {
    try {
      CalibrateSweep(sweep);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message().find("all images have one lens_position"),
            std::string::npos);
  sweep.conditions.values.erase(sweep.input.dataset.images[2].image);
  EXPECT_NE(message().find("has no lens_position"), std::string::npos);
}

TEST(MaxStackOrder, LeavesValuesToTestWith) {
  EXPECT_EQ(MaxStackOrder(2), 1);
  EXPECT_EQ(MaxStackOrder(3), 2);
  EXPECT_EQ(MaxStackOrder(4), 2);
  EXPECT_EQ(MaxStackOrder(5), 3);
  EXPECT_EQ(MaxStackOrder(50), 3);
}

}  // namespace
}  // namespace raygrid
