#include "exchange/external_model.h"

#include "camera/thin_prism_fisheye.h"
#include "camera/view_camera.h"
#include "exchange/opencv_model_list.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kFormImage = {640, 480};

OpenCvModel LensWith(double k3, double k4) {
  return OpenCvModel(kFormImage, WholeImage(kFormImage),
                     {510, 515, 322, 236, -0.15, 0.06, k3, k4, 0, 0, 1e-3, 0});
}

TEST(ExternalModel, HoldsALensOfItsParametersAlone) {
  const ExternalModel external_model = MakeOpenCvModel("five", 5);
  const auto held = ConvertToExternalModel(external_model, LensWith(0.01, 0));
  ASSERT_TRUE(held);
  EXPECT_EQ(held->values, (std::vector<double>{510, 515, 322, 236, -0.15, 0.06,
                                               1e-3, 0, 0.01}));
  EXPECT_EQ(held->Value("k3"), 0.01);
  EXPECT_FALSE(ConvertToExternalModel(external_model, LensWith(0.01, 0.1)));
  EXPECT_FALSE(
      ConvertToExternalModel(MakeOpenCvModel("four", 4), LensWith(0.01, 0)));
  EXPECT_FALSE(ConvertToExternalModel(MakeOpenCvFisheyeModel("fisheye"),
                                      LensWith(0, 0)));
}

TEST(ExternalModel, MakesTheLensThatItHolds) {
  const ExternalModel external_model = MakeOpenCvModel("five", 5);
  const OpenCvModel lens = LensWith(0.01, 0);
  const auto made =
      MakeCameraModel(ConvertToExternalModel(external_model, lens).value());
  EXPECT_EQ(made->Parameters(), lens.Parameters());
  EXPECT_EQ(made->image_size(), kFormImage);
}

TEST(ExternalModel, ShiftsPixelsOfProgramsThatBeginAtTheCorner) {
  ExternalModel external_model = MakeOpenCvModel("corner", 8);
  external_model.origin = PixelOrigin::kImageCorner;
  const auto held =
      ConvertToExternalModel(external_model, ExampleLens()).value();
  EXPECT_EQ(held.Value("cx"), ExampleLens().Parameters()[2] + 0.5);
  EXPECT_EQ(held.Value("cy"), ExampleLens().Parameters()[3] + 0.5);
  EXPECT_EQ(MakeCameraModel(held)->Parameters(), ExampleLens().Parameters());
}

// The middle of an image of 640 x 480 is at (319.5, 239.5).
TEST(ExternalModel, ShiftsPixelsOfProgramsThatBeginInTheMiddle) {
  ExternalModel external_model = MakeOpenCvModel("middle", 8);
  external_model.origin = PixelOrigin::kImageCenter;
  const auto held =
      ConvertToExternalModel(external_model, ExampleLens()).value();
  EXPECT_EQ(held.Value("cx"), ExampleLens().Parameters()[2] - 319.5);
  EXPECT_EQ(held.Value("cy"), ExampleLens().Parameters()[3] - 239.5);
  EXPECT_EQ(MakeCameraModel(held)->Parameters(), ExampleLens().Parameters());
}

TEST(ExternalModel, HasOneFocalLengthIfThereIsOne) {
  const ExternalModel external_model = {
      "simple", "opencv", {"f", "cx", "cy", "k1"}};
  const OpenCvModel lens(kFormImage, WholeImage(kFormImage),
                         {500, 500, 320, 240, -0.1, 0, 0, 0, 0, 0, 0, 0});
  const auto held = ConvertToExternalModel(external_model, lens).value();
  EXPECT_EQ(held.values, (std::vector<double>{500, 320, 240, -0.1}));
  EXPECT_EQ(MakeCameraModel(held)->Parameters(), lens.Parameters());
  EXPECT_FALSE(ConvertToExternalModel(external_model,
                                      LensWith(0, 0)));  // 510 and 515 px
}

// A form of the model with prism and tilt holds the pinhole without them.
TEST(ExternalModel, HoldsAPinholeAmongThoseWithPrismAndTilt) {
  const ExternalModel twelve = MakeOpenCvModel("twelve", 12),
                      eight = MakeOpenCvModel("eight", 8);
  const auto held = ConvertToExternalModel(twelve, ExampleLens()).value();
  const auto expected = ConvertToExternalModel(eight, ExampleLens()).value();
  ASSERT_EQ(held.values.size(), 16u);
  for (const std::string& parameter : eight.parameters)
    EXPECT_EQ(held.Value(parameter), expected.Value(parameter)) << parameter;
  EXPECT_EQ(held.Value("s1"), 0);
}

TEST(ExternalModel, HoldsAnEquidistantViewAsAFisheye) {
  const ViewCamera view(ViewProjection::kEquidistant, kFormImage,
                        WholeImage(kFormImage), {200, 200, 320, 240});
  const auto held =
      ConvertToExternalModel(MakeOpenCvFisheyeModel("fisheye"), view).value();
  EXPECT_EQ(held.values, (std::vector<double>{200, 200, 320, 240, 0, 0, 0, 0}));
  const ViewCamera cylinder(ViewProjection::kCylindrical, kFormImage,
                            WholeImage(kFormImage), {200, 200, 320, 240});
  EXPECT_FALSE(
      ConvertToExternalModel(MakeOpenCvFisheyeModel("fisheye"), cylinder));
}

// This distortion folds at a radius of r (1 - r^2 / 2), with r^2 = 2/3: outside
// of a circle.
TEST(ExternalModel, CountsPixelsThatLookNowhereByArea) {
  const double radius_px = 400 * std::sqrt(2 / 3.0) * (2 / 3.0);
  for (const Eigen::Vector2d& center :
       {Eigen::Vector2d(319.5, 239.5), Eigen::Vector2d(250, 180),
        Eigen::Vector2d(100, 300)}) {
    const OpenCvModel lens(
        kFormImage, WholeImage(kFormImage),
        {400, 400, center.x(), center.y(), -0.5, 0, 0, 0, 0, 0, 0, 0});
    int num_outside = 0;
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; ++x)
        num_outside += (Eigen::Vector2d(x, y) - center).norm() > radius_px;
    EXPECT_NEAR(ComputeUndefinedFraction(lens), num_outside / (640.0 * 480),
                0.004);
  }
}

TEST(ExternalModel, RefusesNumbersThatNoLensHas) {
  const ExternalModel external_model = MakeOpenCvModel("four", 4);
  const auto expect = [&](std::vector<double> values, ImageSize size,
                          const char* word) {
    ExpectError(ExitCode::kInvalidInput, {word}, [&] {
      MakeCameraModel({&external_model, size, std::move(values)});
    });
  };
  expect({500, 500, 320, 240, 0, 0, 0, NAN}, kFormImage, "p2");
  expect({500, 500, 320, INFINITY, 0, 0, 0, 0}, kFormImage, "cy");
  expect({0, 500, 320, 240, 0, 0, 0, 0}, kFormImage, "focal length");
  expect({500, -500, 320, 240, 0, 0, 0, 0}, kFormImage, "focal length");
  expect({500, 500, 320, 240, 0, 0, 0}, kFormImage, "found 7");
  expect({500, 500, 320, 240, 0, 0, 0, 0}, {0, 480}, "image size");
  expect({500, 500, 320, 240, 0, 0, 0, 0}, {1 << 30, 480}, "pixels per side");
  expect({500, 500, 1e9, 240, -1, 0, 0, 0}, kFormImage, "has a valid ray");
}

}  // namespace
}  // namespace raygrid
