#include "camera/model_fitting.h"

#include "camera/central_radial.h"
#include "camera/stereographic.h"
#include "camera/thin_prism_fisheye.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_camera_models.h"
#include "support.h"

namespace raygrid {
namespace {

double RmsPx(const std::string& model, const CameraModel& camera) {
  const FittedModel fit =
      FitParametricModel(model, camera, camera.area(), {true});
  EXPECT_EQ(fit.model->Name(), model);
  const ModelDifference difference = CompareModels(camera, *fit.model, 8);
  const ModelDifference all = CompareModels(camera, camera, 8);
  EXPECT_EQ(difference.pixels.size(), all.pixels.size());
  return difference.rms_px;
}

TEST(FitParametricModel, FindsACameraOfItsKind) {
  EXPECT_LT(RmsPx("opencv", ExampleLens()), 1e-3);
  const ImageSize size = {800, 800};
  const ThinPrismFisheye fisheye(size, WholeImage(size),
                                 {280, 282, 402, 396, 0.02, -0.01, 0.002, -1e-4,
                                  1e-3, -8e-4, 6e-4, -5e-4});
  EXPECT_LT(RmsPx("thin-prism-fisheye", fisheye), 1e-6);
  EXPECT_LT(RmsPx("central-radial", fisheye), 1e-3);
}

TEST(FitParametricModel, FitsPinholesAndFisheyes) {
  const ImageSize size = {640, 480};
  EXPECT_LT(RmsPx("thin-prism-fisheye", *MakeSimulatedCamera("pinhole", size)),
            0.01);
  EXPECT_LT(RmsPx("central-radial", *MakeSimulatedCamera("pinhole", size)),
            0.01);
  EXPECT_LT(
      RmsPx("thin-prism-fisheye", *MakeSimulatedCamera("fisheye190", size)),
      1e-3);
  EXPECT_LT(RmsPx("central-radial", *MakeSimulatedCamera("fisheye190", size)),
            0.01);
}

TEST(FitParametricModel, LeavesWhatItHasNoParametersFor) {
  const auto wide = MakeSimulatedCamera("wide", {640, 480});
  for (const std::string& model : ListModelNames(ModelUse::kCompare)) {
    const double rms_px = RmsPx(model, *wide);
    EXPECT_GT(rms_px, 0.1) << model;
    EXPECT_LT(rms_px, 0.7) << model;
  }
}

// A camera that looks aside: its model may look straight, or not.
TEST(FitParametricModel, TurnsIfItMay) {
  const ImageSize size = {640, 480};
  const auto lens = MakeSimulatedCamera("pinhole", size);
  CentralGeneric grid = FittedGrid(*lens, 40);
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 0.5).normalized()));
  BSplineSurface surface = grid.surface();
  std::vector<SurfaceSample> samples;
  for (int y = 0; y < 480; y += 8)
    for (int x = 0; x < 640; x += 8)
      samples.push_back(
          {{x, y}, ToChart(turn * lens->Unproject({x, y}).value())});
  const CentralGeneric turned(
      size,
      FitSurface(surface.area(), surface.columns(), surface.rows(), samples));
  const FittedModel free =
      FitParametricModel("opencv", turned, turned.area(), {true});
  EXPECT_LT(CompareModels(turned, *free.model, 8).rms_px, 0.01);
  const FittedModel straight =
      FitParametricModel("opencv", turned, turned.area(), {});
  EXPECT_EQ(straight.model_from_camera.angularDistance(
                Eigen::Quaterniond::Identity()),
            0);
}

double LargestCoefficient(const FittedModel& fit) {
  const Eigen::VectorXd parameters = fit.model->Parameters();
  return parameters.tail(parameters.size() - 4).cwiseAbs().maxCoeff();
}

// A webcam's grid, uneven by some tenths of a pixel.
CentralGeneric UnevenGrid(unsigned seed) {
  const ImageSize size = {1280, 720};
  const OpenCvModel lens(size, WholeImage(size),
                         {1150, 1148, 610, 345, 0.1, -0.2, 0, 0, 0, 0, 0, 0});
  BSplineSurface surface = FittedGrid(lens, 80).surface();
  TestRandom random(seed);
  for (int k = 0; k < surface.num_points(); ++k)
    surface.points()[k] += 2e-4 * random.NormalVector<2>();
  return CentralGeneric(size, surface);
}

// Those of a numerator and of a denominator can undo each other.
TEST(FitParametricModel, KeepsCoefficientsSmall) {
  for (const unsigned seed : {1, 3}) {
    const CentralGeneric grid = UnevenGrid(seed);
    for (const char* model : {"opencv", "opencv-14"})
      EXPECT_LT(LargestCoefficient(
                    FitParametricModel(model, grid, grid.area(), {true})),
                10)
          << model << seed;
  }
}

TEST(FitParametricModel, LeavesWhatIsHeld) {
  const OpenCvModel lens = ExampleLens();
  FitOptions options;
  options.held = {"k3", "k4", "k5", "k6"};
  const FittedModel fit =
      FitParametricModel("opencv", lens, lens.area(), options);
  for (const int held :
       {OpenCvModel::kK3, OpenCvModel::kK4, OpenCvModel::kK5, OpenCvModel::kK6})
    EXPECT_EQ(fit.model->Parameters()[held], 0);
  EXPECT_GT(fit.rms_px, 1e-4);
  EXPECT_LT(fit.rms_px, 0.1);
}

TEST(FitParametricModel, TiesFocalLengths) {
  const OpenCvModel lens = ExampleLens();  // 510 and 515 px
  FitOptions options;
  options.ties_focal_lengths = true;
  const FittedModel fit =
      FitParametricModel("opencv", lens, lens.area(), options);
  const Eigen::VectorXd parameters = fit.model->Parameters();
  EXPECT_EQ(parameters[0], parameters[1]);
  EXPECT_GT(parameters[0], 509);
  EXPECT_LT(parameters[0], 516);
}

// A pixel that is not trusted is followed where nothing else tells, and gives
// way.
TEST(FitParametricModel, FollowsTrustedPixels) {
  const auto bumpy = MakeSimulatedCamera("wide", {640, 480});
  ValidityMask mask = ValidityMask::Over(bumpy->image_size());
  for (size_t k = 0; k < mask.is_valid.size(); ++k) {
    const Eigen::Vector2d at = mask.CellCenter(static_cast<int>(k));
    mask.is_valid[k] = std::abs(at.x() - 320) < 120 && at.y() < 160;
  }
  FitOptions options;
  options.valid_region = &mask;
  const FittedModel valid_region =
      FitParametricModel("opencv", *bumpy, bumpy->area(), options);
  const FittedModel all =
      FitParametricModel("opencv", *bumpy, bumpy->area(), {});
  double sum_trusted = 0, sum_all = 0;
  for (int y = 0; y < 155; y += 10) {
    for (int x = 210; x < 430; x += 10) {
      const Eigen::Vector3d ray = bumpy->Unproject({x, y}).value();
      const Eigen::Vector2d pixel(x, y);
      sum_trusted +=
          (valid_region.model->Project(ray, nullptr, 99).value() - pixel)
              .norm();
      sum_all += (all.model->Project(ray, nullptr, 99).value() - pixel).norm();
    }
  }
  EXPECT_LT(sum_trusted, 0.7 * sum_all);
  // The rest of the image has the same lens, not any one.
  EXPECT_LT(CompareModels(*bumpy, *valid_region.model, 8).p99_px, 10);
}

TEST(FitParametricModel, OpenCvHasNothingBehind) {
  const auto lens = MakeSimulatedCamera("fisheye190", {640, 480});
  const FittedModel fit =
      FitParametricModel("opencv", *lens, lens->area(), {true});
  EXPECT_FALSE(fit.model->Unproject({1, 240}));
}

}  // namespace
}  // namespace raygrid
