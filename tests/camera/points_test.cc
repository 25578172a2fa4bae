#include "points.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "camera_error.h"
#include "camera_support.h"
#include "temporary_folder.h"

namespace raygrid {
namespace {

bool Never() { return false; }

// The output for a file of points.
std::string Undistorted(const std::string& points,
                        const std::optional<rg_mode>& mode = std::nullopt,
                        rg_camera camera = OpenLens()) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.csv";
  std::ofstream(in) << points;
  char* text = nullptr;
  size_t size = 0;
  std::FILE* const output = open_memstream(&text, &size);
  OperatingPointFollower stack(&camera);
  std::string result;
  try {
    UndistortPoints(camera, mode, in, output, Never, &stack);
    std::fclose(output);
    result.assign(text, size);
    std::free(text);
  } catch (...) {
    std::fclose(output);
    std::free(text);
    throw;
  }
  return result;
}

TEST(Points, AreThoseOfTheRuntime) {
  std::ostringstream points;
  points << "x,y\n# a comment\n";
  std::string expected = "x,y,u,v\n";
  const rg_camera camera = OpenLens();
  for (int x = 0; x < 200; x += 13) {
    points << x << ".5," << x / 2 << "\n";
    char line[100];
    rg_pixel to;
    const rg_pixel pixel = {RG_PIXEL(x) + 0x8000, RG_PIXEL(x / 2)};
    if (rg_undistort_point(&camera, pixel, &to) == RG_OK)
      std::snprintf(line, sizeof(line), "%d.5,%d,%.5f,%.5f\n", x, x / 2,
                    to.x_q16 / 65536.0, to.y_q16 / 65536.0);
    else
      std::snprintf(line, sizeof(line), "%d.5,%d,,\n", x, x / 2);
    expected += line;
  }
  EXPECT_EQ(Undistorted(points.str()), expected);
}

TEST(Points, OfAModeAreBroughtToCalibratedOnes) {
  rg_mode mode = {};
  mode.width = 80;
  mode.height = 60;
  mode.scale_x_q16 = mode.scale_y_q16 = 2 << 16;
  const std::string binned = Undistorted("40,30\n", mode);
  const std::string calibrated = Undistorted("80.5,60.5\n");
  const std::string positions =
      calibrated.substr(calibrated.rfind("60.5,") + 5);
  EXPECT_EQ(binned, "x,y,u,v\n40,30," + positions);
}

TEST(Points, LinesThatAreNoPointsAreNamed) {
  for (const char* line : {"1,2,3\n", "abc\n", "1\n", "nan,1\n", "1e9,1\n",
                           "1,2,nan\n", "1,2,3,4\n", "1,2,\n"}) {
    try {
      Undistorted(std::string("x,y\n1,2\n") + line);
      ADD_FAILURE() << line;
    } catch (const CameraError& error) {
      EXPECT_EQ(error.code(), CameraExit::kInput);
      EXPECT_NE(std::string(error.what()).find("in.csv:3"), std::string::npos);
    }
  }
}

// By the camera of the lens position that a line tells, which those behind it
// keep.
TEST(Points, FollowTheLens) {
  rg_camera camera;
  ASSERT_EQ(rg_camera_open(&camera, kStackBlob, sizeof(kStackBlob)), RG_OK);
  ASSERT_EQ(rg_select_remap(&camera, 0), RG_OK);
  std::string expected = "x,y,u,v\n";
  const auto expect_at = [&](int32_t value_q16) {
    rg_camera there = camera;
    ASSERT_EQ(rg_set_operating_point(&there, value_q16), RG_OK);
    rg_pixel to;
    ASSERT_EQ(rg_undistort_point(&there, {RG_PIXEL(40), RG_PIXEL(30)}, &to),
              RG_OK);
    char line[100];
    std::snprintf(line, sizeof(line), "40,30,%.5f,%.5f\n", to.x_q16 / 65536.0,
                  to.y_q16 / 65536.0);
    expected += line;
  };
  expect_at(5 << 16);
  expect_at(5 << 16);
  expect_at(1 << 14);
  EXPECT_EQ(Undistorted("x,y,lens_position\n40,30,5\n40,30\n40,30, 0.25\n",
                        std::nullopt, camera),
            expected);
  EXPECT_NE(expected.substr(8, 20), expected.substr(expected.size() - 21, 20));
}

}  // namespace
}  // namespace raygrid
