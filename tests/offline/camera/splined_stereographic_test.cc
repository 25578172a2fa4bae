#include "camera/splined_stereographic.h"

#include "camera/thin_prism_fisheye.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

const ImageSize kSplinedSize = {640, 480};

// A lens whose control points wave by so much.
SplinedStereographic ExampleSplined(double wave) {
  const SplinedStereographic::Grid grid = {10, 8, 120};
  Eigen::VectorXd parameters(2 * 80 + 4);
  for (int k = 0; k < 160; ++k) parameters[k] = wave * std::cos(k);
  parameters.tail<4>() << 300, 301, 320, 240;
  return {kSplinedSize, Area{100, 80, 520, 400}, grid, parameters};
}

// The pixels that mrcal 2.2 says.
TEST(SplinedStereographic, IsThatOfMrcal) {
  const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>> seen = {
      {{0.3, 0.2, 1}, {405.012859353410, 296.617962577174}},
      {{-0.7, 0.4, 1}, {135.190376594981, 346.668407678437}},
      {{0.01, -0.02, 1}, {325.046744956689, 234.236697583533}},
      {{1.2, 0.5, 0.9}, {610.512168223484, 359.570720203637}}};
  for (const auto& [point, pixel] : seen) {
    const auto ours = ExampleSplined(0.02).Project(point, nullptr, 100);
    ASSERT_TRUE(ours);
    EXPECT_LT((*ours - pixel).norm(), 1e-10);
  }
}

TEST(SplinedStereographic, ProjectionInvertsUnprojection) {
  ExpectRoundTrip(ExampleSplined(0.02), 1e-9);
}

TEST(SplinedStereographic, DerivativesAreThoseOfProjection) {
  ExpectDerivativeByPoint(ExampleSplined(0.02), 1e-5);
  ExpectDerivativeByParameter(ExampleSplined(0.02), 1e-5, 1e-5);
}

TEST(SplinedStereographic, EndsWithItsCellsAndWhereItFolds) {
  const SplinedStereographic plain = ExampleSplined(0);
  const double edge_rad = M_PI / 3;
  for (const double theta : {edge_rad - 1e-3, edge_rad + 1e-3})
    EXPECT_EQ(plain.Project({std::sin(theta), 0, std::cos(theta)}, nullptr, 1e9)
                  .has_value(),
              theta < edge_rad);
  EXPECT_FALSE(plain.Project({0, 0, -1}, nullptr, 1e9));
  EXPECT_FALSE(plain.Project({0, 0, 0}, nullptr, 1e9));
  int num_nowhere = 0;
  const SplinedStereographic folded = ExampleSplined(0.8);
  TestRandom random(3);
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector2d pixel = random.PixelIn(folded.area());
    const auto ray = folded.Unproject(pixel);
    if (!ray) {
      ++num_nowhere;
      continue;
    }
    EXPECT_LT((*folded.Project(*ray, nullptr, 1e9) - pixel).norm(), 1e-6);
  }
  EXPECT_GT(num_nowhere, 0);
}

// The error at pixels that are not those of the fit; all are to be seen.
double RmsAtRandomPx(const CameraModel& lens, const SplinedStereographic& fit) {
  TestRandom random(5);
  double sum = 0;
  int count = 0;
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector2d pixel = random.PixelIn(fit.area());
    const auto ray = lens.Unproject(pixel);
    if (!ray || !lens.IsInImageCircle(pixel)) continue;
    const auto seen = fit.Project(*ray, nullptr, 10);
    sum += seen ? (*seen - pixel).squaredNorm() : 1e6;
    ++count;
  }
  EXPECT_GT(count, 400);
  return std::sqrt(sum / count);
}

TEST(SplinedStereographic, FitsFollowLenses) {
  for (const char* name : {"wide", "fisheye190"}) {
    const auto lens = MakeSimulatedCamera(name, kSplinedSize);
    const auto fit = FitSplinedStereographic(*lens, nullptr);
    ASSERT_TRUE(fit);
    EXPECT_LT(RmsAtRandomPx(*lens, *fit), 0.005) << name;
    // An error of half a pixel is seen.
    Eigen::VectorXd parameters = fit->Parameters();
    parameters.tail<1>()[0] += 0.5;
    fit->SetParameters(parameters);
    EXPECT_GT(RmsAtRandomPx(*lens, *fit), 0.4) << name;
  }
}

TEST(SplinedStereographic, FitsTakeTheGridThatIsTold) {
  const auto lens = MakeSimulatedCamera("wide", kSplinedSize);
  const auto covering = FitSplinedStereographic(*lens, nullptr, {{30, 20, 0}});
  EXPECT_EQ(covering->grid().columns, 30);
  EXPECT_EQ(covering->grid().rows, 20);
  EXPECT_LT(RmsAtRandomPx(*lens, *covering), 0.005);
  // Pixels beyond a narrow grid have no say.
  const auto narrow = FitSplinedStereographic(*lens, nullptr, {{30, 20, 40}});
  EXPECT_EQ(narrow->grid().fov_x_deg, 40);
  const Eigen::Vector3d ray = *lens->Unproject({320, 240});
  EXPECT_LT(
      (*narrow->Project(ray, nullptr, 0) - Eigen::Vector2d(320, 240)).norm(),
      0.001);
  EXPECT_FALSE(narrow->Project(*lens->Unproject({3, 3}), nullptr, 0));
}

// Pixels beyond the image circle look anywhere, and would widen the grid.
TEST(SplinedStereographic, FitsEndWithTheImageCircle) {
  const auto lens = MakeSimulatedCamera("fisheye190", kSplinedSize);
  const auto whole = FitSplinedStereographic(*lens, nullptr);
  lens->SetImageCircle(ImageCircle{{320, 240}, {215, 215}});
  const auto lit = FitSplinedStereographic(*lens, nullptr);
  EXPECT_LT(lit->grid().fov_x_deg, whole->grid().fov_x_deg - 20);
  EXPECT_LT(RmsAtRandomPx(*lens, *lit), 0.005);
}

TEST(SplinedStereographic, FitsHaveFewPointsAcrossNarrowImages) {
  for (const ImageSize& size : {ImageSize{20, 900}, ImageSize{900, 20}}) {
    const ThinPrismFisheye lens(
        size, WholeImage(size),
        {400, 400, size.width / 2.0, size.height / 2.0, 0.02, -0.01});
    const auto fit = FitSplinedStereographic(lens, nullptr);
    ASSERT_TRUE(fit);
    EXPECT_LE(std::max(fit->grid().columns, fit->grid().rows), 55);
    EXPECT_LE(std::min(fit->grid().columns, fit->grid().rows), 7);
  }
  const ImageSize line = {1, 90};
  EXPECT_FALSE(FitSplinedStereographic(
      ThinPrismFisheye(line, WholeImage(line), {80, 80, 0, 45}), nullptr));
}

TEST(SplinedStereographic, FitsFollowTrustedPixels) {
  const auto lens = MakeSimulatedCamera("wide", kSplinedSize);
  ValidityMask mask = ValidityMask::Over(kSplinedSize);
  for (size_t k = 0; k < mask.is_valid.size(); ++k)
    mask.is_valid[k] = static_cast<int>(k) % mask.columns < mask.columns / 2;
  const auto rms_px = [&](const SplinedStereographic& fit) {
    double sum = 0;
    for (int k = 0; k < 300; ++k) {
      const Eigen::Vector2d pixel(k, 80 + k);
      sum += (*fit.Project(*lens->Unproject(pixel), nullptr, 9) - pixel)
                 .squaredNorm();
    }
    return std::sqrt(sum / 300);
  };
  const auto all = FitSplinedStereographic(*lens, nullptr);
  const auto half = FitSplinedStereographic(*lens, &mask);
  EXPECT_NE(half->Parameters().tail<4>(), all->Parameters().tail<4>());
  EXPECT_LT(rms_px(*half), 0.01);
}

}  // namespace
}  // namespace raygrid
