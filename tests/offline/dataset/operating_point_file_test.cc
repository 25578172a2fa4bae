// Files of cameras over ranges of conditions, and such a camera at a value.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "dataset/camera_file.h"
#include "dataset/error.h"
#include "dataset/fixed_operating_point.h"
#include "example_camera_file.h"
#include "support.h"

namespace raygrid {
namespace {

CameraFile StackFile() {
  CameraFile file = GridFile();
  const auto& grid = dynamic_cast<const CentralGeneric&>(*file.camera);
  OperatingPointModel stack({{OperatingParameter::kTemperature, 20, 60}}, {2},
                            grid);
  for (int j = 1; j <= 2; ++j)
    for (int k = 0; k < grid.surface().num_points(); ++k)
      stack.terms()[j].points()[k] = {1e-3 * j * k, -2e-4 * k};
  file.uncertainty = ExampleUncertainty();
  file.uncertainty->lattice.stddev_px[4] = 0.05;
  UncertaintyLattice warm = file.uncertainty->lattice;
  for (double& deviation : warm.stddev_px) deviation *= 2;
  file.stack = OperatingPointCalibration{
      stack, {{{20}, file.uncertainty->lattice}, {{60}, warm}}};
  return file;
}

TEST(CameraFile, KeepsAStack) {
  const CameraFile file = StackFile();
  const CameraFile read = ParseCameraFile("f.yaml", FormatCameraFile(file));
  ASSERT_TRUE(read.stack.has_value());
  const OperatingRange range = read.stack->cameras.ranges()[0];
  EXPECT_EQ(range.condition, OperatingParameter::kTemperature);
  EXPECT_EQ(range.low, 20);
  EXPECT_EQ(range.high, 60);
  for (const double value : {20.0, 33.0, 60.0})
    EXPECT_LT((read.stack->cameras.At({value}).Parameters() -
               file.stack->cameras.At({value}).Parameters())
                  .cwiseAbs()
                  .maxCoeff(),
              1e-11);
  ASSERT_EQ(read.stack->deviations.size(), 2u);
  EXPECT_EQ(read.stack->deviations[1].values, OperatingPoint{60});
  EXPECT_EQ(read.stack->deviations[1].lattice.stddev_px[0], 0.02);
  EXPECT_EQ(FormatCameraFile(read), FormatCameraFile(file));
}

TEST(CameraFile, OfAStackAtAValueIsThatCameraAlone) {
  const CameraFile file = StackFile();
  const CameraFile at = MakeCameraFileAt(file, {30});
  EXPECT_FALSE(at.stack.has_value());
  EXPECT_EQ(at.camera->Parameters(), file.stack->cameras.At({30}).Parameters());
  // A quarter of the way from one to twice the deviations.
  EXPECT_NEAR(at.uncertainty->lattice.stddev_px[0], 0.0125, 1e-12);
  EXPECT_EQ(at.capture->sensor_temperature_c, 30);
}

// Deviations are 1, 2 and 4, 8 times one lattice.
CameraFile StackFileOfBoth() {
  CameraFile file = GridFile();
  const auto& grid = dynamic_cast<const CentralGeneric&>(*file.camera);
  OperatingPointModel stack({{OperatingParameter::kLensPosition, 0, 10},
                             {OperatingParameter::kTemperature, 20, 60}},
                            {2, 1}, grid);
  for (int j = 1; j <= 3; ++j)
    for (int k = 0; k < grid.surface().num_points(); ++k)
      stack.terms()[j].points()[k] = {1e-3 * j * k, -2e-4 * k};
  file.uncertainty = ExampleUncertainty();
  file.stack = OperatingPointCalibration{stack, {}};
  double factor = 1;
  for (const double position : {0, 10})
    for (const double temperature : {20, 60}) {
      file.stack->deviations.push_back(
          {{position, temperature}, file.uncertainty->lattice});
      for (double& deviation : file.stack->deviations.back().lattice.stddev_px)
        deviation *= factor;
      factor *= 2;
    }
  return file;
}

TEST(CameraFile, KeepsAStackOfTwoConditions) {
  const CameraFile file = StackFileOfBoth();
  const std::string text = FormatCameraFile(file);
  const CameraFile read = ParseCameraFile("f.yaml", text);
  ASSERT_TRUE(read.stack.has_value());
  EXPECT_EQ(read.stack->cameras.orders(), (std::vector<int>{2, 1}));
  for (const OperatingPoint& values :
       {OperatingPoint{0, 33}, OperatingPoint{7.5, 60}})
    EXPECT_LT((read.stack->cameras.At(values).Parameters() -
               file.stack->cameras.At(values).Parameters())
                  .cwiseAbs()
                  .maxCoeff(),
              1e-11);
  ASSERT_EQ(read.stack->deviations.size(), 4u);
  EXPECT_EQ(read.stack->deviations[2].values, (OperatingPoint{10, 20}));
  EXPECT_EQ(FormatCameraFile(read), text);
  std::string swapped = text;
  swapped.replace(swapped.find("condition: temperature"), 22,
                  "condition: lens_position");
  EXPECT_THROW(ParseCameraFile("f.yaml", swapped), InputError);
}

TEST(CameraFile, OfTwoConditionsIsHeldAtOneOrBoth) {
  const CameraFile file = StackFileOfBoth();
  const double once_px = file.uncertainty->lattice.stddev_px[0];
  const CameraFile near = MakeCameraFileAt(file, {10, std::nullopt});
  ASSERT_TRUE(near.stack.has_value());
  EXPECT_EQ(near.camera->Parameters(),
            near.stack->cameras.At({40}).Parameters());
  EXPECT_EQ(near.capture->lens_position, 10);
  EXPECT_FALSE(near.capture->sensor_temperature_c.has_value());
  ASSERT_EQ(near.stack->deviations.size(), 2u);
  EXPECT_EQ(near.stack->deviations[0].values, OperatingPoint{20});
  EXPECT_NEAR(near.stack->deviations[1].lattice.stddev_px[0], 8 * once_px,
              1e-12);
  EXPECT_NEAR(near.uncertainty->lattice.stddev_px[0], 6 * once_px, 1e-12);
  // Half of the way in both.
  const CameraFile at = MakeCameraFileAt(file, {5, 40});
  EXPECT_FALSE(at.stack.has_value());
  EXPECT_LT(
      (at.camera->Parameters() - file.stack->cameras.At({5, 40}).Parameters())
          .cwiseAbs()
          .maxCoeff(),
      1e-15);
  EXPECT_NEAR(at.uncertainty->lattice.stddev_px[0], 3.75 * once_px, 1e-12);
  EXPECT_EQ(at.capture->sensor_temperature_c, 40);
}

TEST(CameraFile, OfAStackTrustsNoCellThatIsKnownTooBadlyThere) {
  CameraFile file = StackFileOfBoth();
  file.uncertainty->lattice.stddev_px[4] = 0.05;
  double factor = 1;
  for (OperatingPointUncertainty& known : file.stack->deviations) {
    known.lattice.stddev_px[4] = 0.05 * factor;
    factor *= 2;
  }
  std::vector<bool>& valid_region = file.uncertainty->mask.is_valid;
  valid_region.assign(valid_region.size(), true);
  const auto& deviations = file.uncertainty->lattice.stddev_px;
  file.uncertainty->max_stddev_px =
      2.5 * *std::max_element(deviations.begin(), deviations.end());
  const size_t all = valid_region.size();
  const auto num_trusted = [](const std::optional<CameraUncertainty>& known) {
    const std::vector<bool>& cells = known->mask.is_valid;
    return static_cast<size_t>(std::count(cells.begin(), cells.end(), true));
  };
  EXPECT_EQ(num_trusted(MakeCameraFileAt(file, {0, 20}).uncertainty), all);
  EXPECT_EQ(num_trusted(MakeCameraFileAt(file, {0, 60}).uncertainty), all);
  const size_t at_end =
      num_trusted(MakeCameraFileAt(file, {10, 60}).uncertainty);
  EXPECT_LT(at_end, all);
  const auto everywhere = ComputeMaxUncertainty(file);
  EXPECT_EQ(num_trusted(everywhere), at_end);
  EXPECT_EQ(everywhere->lattice.stddev_px[0], 8 * deviations[0]);
  // A camera that does not tell at one value is not known everywhere.
  file.stack->deviations[1].lattice.stddev_px[0] = NAN;
  EXPECT_TRUE(std::isnan(ComputeMaxUncertainty(file)->lattice.stddev_px[0]));
}

TEST(CameraFile, RefusesAMalformedStack) {
  const std::string text = FormatCameraFile(StackFile());
  const auto expect_refused = [&](const std::string& from,
                                  const std::string& to,
                                  const std::string& why) {
    std::string edited = text;
    const size_t place = edited.find(from);
    ASSERT_NE(place, std::string::npos) << from;
    edited.replace(place, from.size(), to);
    try {
      ParseCameraFile("f.yaml", edited);
      ADD_FAILURE() << to;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos)
          << error.what();
    }
  };
  expect_refused("condition: temperature", "condition: pressure",
                 "unknown quantity 'pressure'");
  expect_refused("condition: temperature", "about: temperature",
                 "missing 'condition'");
  expect_refused("range: [20, 60]", "range: [60, 20]",
                 "range of temperature: 60 is not less than 20");
  expect_refused("range: [20, 60]", "range: [20, .nan]",
                 "range of temperature");
  for (const char* range : {"range: [20]", "range: 20", "rang: [20, 60]"})
    expect_refused("range: [20, 60]", range,
                   "range of temperature: expected the calibrated range");
  const int count = 2 * dynamic_cast<const CentralGeneric&>(*StackFile().camera)
                            .surface()
                            .num_points();
  expect_refused("changes:\n    - [", "changes:\n    - [0, ",
                 fmt::format("list 1 of 'changes' with temperature: a list of "
                             "{}, expected a pair per control point, {} ",
                             count + 1, count));
  expect_refused("changes:\n    - [", "changes:\n    - 7\n    - [",
                 "list 1 of 'changes' with temperature: not a list");
  expect_refused("changes:", "change:", "'changes' with temperature: none");
  expect_refused("changes:", "changes: few\n  others:",
                 "'changes' with temperature: not a list");
  expect_refused("changes:", "changes: []\n  others:",
                 "'changes' with temperature: a list of 0, expected 1 to 3 ");
  expect_refused("- at: 60", "- at: 20", "ascending");
}

}  // namespace
}  // namespace raygrid
