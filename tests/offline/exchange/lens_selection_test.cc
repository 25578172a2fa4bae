#include "exchange/external_model_selection.h"
#include "exchange/opencv_model_list.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kChoiceImage = {640, 480};

class LensChoice : public ::testing::Test {
 protected:
  const ExternalModel four_ = MakeOpenCvModel("four", 4),
                      five_ = MakeOpenCvModel("five", 5),
                      eight_ = MakeOpenCvModel("eight", 8),
                      fisheye_ = MakeOpenCvFisheyeModel("fisheye");
  const std::vector<const ExternalModel*> all_ = {&eight_, &five_, &four_,
                                                  &fisheye_};
};

TEST_F(LensChoice, IsTheCameraItselfInTheShortestForm) {
  const OpenCvModel lens(kChoiceImage, WholeImage(kChoiceImage),
                         {510, 515, 322, 236, -0.15, 0.06, 0, 0, 0, 0, 0, 0});
  const SelectedModel chosen = SelectExternalModel(all_, lens, nullptr);
  EXPECT_EQ(chosen.lens.external_model->name, "four");
  EXPECT_FALSE(chosen.fit);
  EXPECT_EQ(SelectExternalModel(all_, ExampleLens(), nullptr)
                .lens.external_model->name,
            "eight");
}

// A grid that an OpenCV lens with five coefficients is behind.
TEST_F(LensChoice, TakesTheFewestCoefficientsThatDo) {
  const OpenCvModel lens(
      kChoiceImage, WholeImage(kChoiceImage),
      {510, 515, 322, 236, -0.25, 0.1, 0.05, 0, 0, 0, 1e-3, 2e-3});
  const CentralGeneric grid = FittedGrid(lens, 20);
  const SelectedModel chosen = SelectExternalModel(all_, grid, nullptr);
  EXPECT_EQ(chosen.lens.external_model->name, "five");
  ASSERT_TRUE(chosen.fit);
  EXPECT_LT(chosen.fit->max_px, 0.02);
  EXPECT_FALSE(chosen.fit->IsTurned());
  EXPECT_EQ(chosen.fit->num_unrepresentable, 0u);
  // Four leave much more, and are taken if nothing else may be.
  const SelectedModel four = SelectExternalModel({&four_}, grid, nullptr);
  EXPECT_GT(four.fit->rms_px, 2 * chosen.fit->rms_px);
}

// Fits of a double sphere start with xi; a unified camera has none.
TEST_F(LensChoice, FitsAFormWithoutAParameterOfEveryStart) {
  const ExternalModel unified =
      MakeExternalModel("unified", "double-sphere", {"alpha"});
  const auto lens =
      MakeCameraModel({&unified, kChoiceImage, {250, 251, 322, 236, 0.6}});
  const SelectedModel chosen =
      SelectExternalModel({&unified}, FittedGrid(*lens, 20), nullptr);
  ASSERT_TRUE(chosen.fit);
  EXPECT_LT(chosen.fit->max_px, 0.02);
}

// The error told is that of the lens that is written.
TEST_F(LensChoice, MeasuresTheLensThatIsWritten) {
  const auto wide = MakeSimulatedCamera("wide", kChoiceImage);
  const SelectedModel chosen = SelectExternalModel({&eight_}, *wide, nullptr);
  const auto written = MakeCameraModel(chosen.lens);
  double sum = 0, worst = 0;
  int count = 0;
  for (double y = 0; y < kChoiceImage.height; y += 5) {
    for (double x = 0; x < kChoiceImage.width; x += 5) {
      const Eigen::Vector2d pixel(x, y);
      const Eigen::Vector3d ray =
          chosen.fit->fitted_from_camera * wide->Unproject(pixel).value();
      const double error =
          (written->Project(ray, nullptr, 1e9).value() - pixel).norm();
      sum += error * error;
      worst = std::max(worst, error);
      ++count;
    }
  }
  EXPECT_NEAR(chosen.fit->rms_px, std::sqrt(sum / count), 0.02);
  EXPECT_NEAR(chosen.fit->max_px, worst, 0.1);
}

TEST_F(LensChoice, CountsWhatLiesBeyondAForm) {
  const auto lens = MakeSimulatedCamera("fisheye190", kChoiceImage);
  const SelectedModel chosen = SelectExternalModel(all_, *lens, nullptr);
  EXPECT_EQ(chosen.lens.external_model->name, "fisheye");
  EXPECT_GT(chosen.fit->num_unrepresentable, 1000u);
  EXPECT_GT(chosen.fit->max_valid_angle_rad, 95 * M_PI / 180);
  EXPECT_NE(FormatModelFit(*chosen.fit).find("degrees off axis"),
            std::string::npos);
}

TEST_F(LensChoice, ComparesTrustedPixelsAlone) {
  const auto wide = MakeSimulatedCamera("wide", kChoiceImage);
  ValidityMask mask = ValidityMask::Over(kChoiceImage);
  for (size_t k = 0; k < mask.is_valid.size(); ++k)
    mask.is_valid[k] = mask.CellCenter(static_cast<int>(k)).x() < 320;
  const ModelFit half = *SelectExternalModel({&eight_}, *wide, &mask).fit;
  const ModelFit all = *SelectExternalModel({&eight_}, *wide, nullptr).fit;
  EXPECT_NEAR(static_cast<double>(half.num_pixels),
              static_cast<double>(all.num_pixels) / 2, 0.05 * all.num_pixels);
  EXPECT_LT(half.rms_px, all.rms_px);
  EXPECT_TRUE(half.has_valid_region);
}

TEST_F(LensChoice, RefusesCamerasOfLines) {
  const NonCentralGeneric lines = ExampleLines();
  ExpectError(ExitCode::kUsage, {"is non-central", "view"},
              [&] { SelectExternalModel(all_, lines, nullptr); });
}

}  // namespace
}  // namespace raygrid
