#include "simulation/checkered_room.h"

#include "support.h"

namespace raygrid {
namespace {

OpenCvModel PlainCamera() {
  OpenCvModel::ParameterArray parameters = {};
  parameters[OpenCvModel::kFx] = parameters[OpenCvModel::kFy] = 200;
  parameters[OpenCvModel::kCx] = 160;
  parameters[OpenCvModel::kCy] = 120;
  return OpenCvModel({321, 241}, {0, 0, 320, 200}, parameters);
}

TEST(CheckeredRoom, ShowsSquaresThatMeetInTheAxis) {
  const Image image = RenderCheckeredRoom(PlainCamera(), 0.25, 7, 1);
  ASSERT_EQ(image.size, (ImageSize{321, 241}));
  const auto blue = [&](int x, int y) {
    return image.pixels[y * image.stride() + 3 * x];
  };
  // A square has 50 pixels; squares that touch by a corner have one colour.
  EXPECT_EQ(blue(170, 130), blue(150, 110));
  EXPECT_EQ(blue(170, 110), blue(150, 130));
  EXPECT_GT(blue(170, 130), 1.5 * blue(150, 130));
  EXPECT_EQ(blue(208, 130), blue(162, 130));
  EXPECT_EQ(blue(212, 130), blue(150, 130));
  // Rows below the area are not calibrated.
  EXPECT_EQ(blue(160, 210), 7);
  EXPECT_EQ(RenderCheckeredRoom(PlainCamera(), 0.25, 7, 3).pixels,
            image.pixels);
}

TEST(CheckeredRoom, HasAboutADozenSquaresAcross) {
  for (const char* lens : {"pinhole", "wide", "fisheye", "fisheye190"}) {
    const auto camera = MakeSimulatedCamera(lens, {320, 240});
    const double across = ComputeVisibleAngleDeg(*camera, 0) * M_PI / 180 /
                          ComputeSceneSquareSize(*camera);
    EXPECT_GT(across, 8) << lens;
    EXPECT_LT(across, 17) << lens;
  }
}

TEST(SeenAngle, IsThatBetweenTheAreasEdges) {
  // The area's middle row lies 20 pixels above the axis.
  const double half_rad = std::atan(160 / std::hypot(200.0, 20.0));
  EXPECT_NEAR(ComputeVisibleAngleDeg(PlainCamera(), 0),
              2 * half_rad * 180 / M_PI, 1e-9);
  EXPECT_NEAR(
      ComputeVisibleAngleDeg(*MakeSimulatedCamera("fisheye190", {640, 480}), 0),
      190, 3);
}

}  // namespace
}  // namespace raygrid
