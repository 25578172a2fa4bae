#include "camera/model_fitting.h"

#include "camera/central_radial.h"
#include "camera/stereographic.h"
#include "camera/thin_prism_fisheye.h"
#include "evaluation/model_difference.h"
#include "simulation/simulated_lenses.h"
#include "support.h"

namespace raygrid {
namespace {

double RmsPx(const std::string& model, const CameraModel& camera) {
  const FittedModel fit =
      FitParametricModel(model, camera, camera.area(), true);
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
  EXPECT_LT(RmsPx("thin-prism-fisheye", *SimulatedLens("pinhole", size)), 0.01);
  EXPECT_LT(RmsPx("central-radial", *SimulatedLens("pinhole", size)), 0.01);
  EXPECT_LT(RmsPx("thin-prism-fisheye", *SimulatedLens("fisheye190", size)),
            1e-3);
  EXPECT_LT(RmsPx("central-radial", *SimulatedLens("fisheye190", size)), 0.01);
}

TEST(FitParametricModel, LeavesWhatItHasNoParametersFor) {
  const auto wide = SimulatedLens("wide", {640, 480});
  for (const char* model : {"opencv", "thin-prism-fisheye", "central-radial"}) {
    const double rms_px = RmsPx(model, *wide);
    EXPECT_GT(rms_px, 0.1) << model;
    EXPECT_LT(rms_px, 0.7) << model;
  }
}

// A camera that looks aside: its model may look straight, or not.
TEST(FitParametricModel, TurnsIfItMay) {
  const ImageSize size = {640, 480};
  const auto lens = SimulatedLens("pinhole", size);
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
      FitParametricModel("opencv", turned, turned.area(), true);
  EXPECT_LT(CompareModels(turned, *free.model, 8).rms_px, 0.01);
  const FittedModel straight =
      FitParametricModel("opencv", turned, turned.area(), false);
  EXPECT_EQ(straight.model_from_camera.angularDistance(
                Eigen::Quaterniond::Identity()),
            0);
}

TEST(FitParametricModel, OpenCvHasNothingBehind) {
  const auto lens = SimulatedLens("fisheye190", {640, 480});
  const FittedModel fit =
      FitParametricModel("opencv", *lens, lens->area(), true);
  EXPECT_FALSE(fit.model->Unproject({1, 240}));
}

}  // namespace
}  // namespace raygrid
