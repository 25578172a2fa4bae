#include "evaluation/uncertainty_summary.h"

#include "camera/opencv.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kSummarySize = {640, 480};

std::unique_ptr<CameraModel> Camera() {
  return std::make_unique<OpenCvModel>(
      kSummarySize, Area{0, 0, 639, 479},
      OpenCvModel::ParameterArray{500, 500, 319.5, 239.5});
}

// Supported but for the cells that a function names.
template <typename IsBeyond>
ValidityMask SupportedBut(const IsBeyond& is_beyond) {
  ValidityMask mask = ValidityMask::Over(kSummarySize);
  for (int cell = 0; cell < mask.columns * mask.rows; ++cell)
    mask.is_valid[cell] = !is_beyond(mask.CellCenter(cell));
  return mask;
}

UncertaintyLattice Lattice(double left_px, double right_px) {
  return {2, 2, {left_px, right_px, left_px, right_px}};
}

bool IsInCorner(const Eigen::Vector2d& pixel) {
  return std::min(pixel.x(), 640 - pixel.x()) +
             std::min(pixel.y(), 480 - pixel.y()) <
         100;
}

TEST(UncertaintyLattice, InterpolatesBesideUndefinedNodes) {
  const UncertaintyLattice lattice = {3, 2, {1, 2, NAN, 3, 4, NAN}};
  const Area area = {0, 0, 20, 10};
  EXPECT_DOUBLE_EQ(lattice.At(area, {5, 5}), 2.5);
  EXPECT_DOUBLE_EQ(lattice.At(area, {10, 10}), 4);
  EXPECT_DOUBLE_EQ(lattice.At(area, {14, 5}), 3);
  EXPECT_TRUE(std::isnan(lattice.At(area, {16, 5})));
}

TEST(UncertaintySummary, SharesAreOfTheImage) {
  CameraUncertainty uncertainty;
  uncertainty.lattice = Lattice(0, 1);  // from the left to the right edge
  uncertainty.mask =
      SupportedBut([](const auto& pixel) { return pixel.x() > 480; });
  const UncertaintySummary summary =
      SummarizeUncertainty(*Camera(), uncertainty);
  const double expected[] = {0.05, 0.1, 0.2, 0.5, 1};
  for (size_t k = 0; k < kShareLimitsPx.size(); ++k)
    EXPECT_NEAR(summary.share_below[k], expected[k], 0.02);
  EXPECT_NEAR(summary.valid_share, 0.75, 0.02);
}

TEST(UncertaintySummary, SharesAreOfTheImageCircle) {
  const auto camera = Camera();
  camera->SetImageCircle(ImageCircle{{319.5, 239.5}, {240, 240}});
  EXPECT_NEAR(ComputeValidShare(
                  *camera, SupportedBut([](const auto&) { return false; })),
              1, 1e-9);
  EXPECT_NEAR(ComputeValidShare(*camera, SupportedBut([](const auto& pixel) {
                return pixel.x() > 320;
              })),
              0.5, 0.02);
}

TEST(UncertaintySummary, SaysWhatIsExtrapolated) {
  const auto camera = Camera();
  const auto image_regions = [&](const auto& is_beyond) {
    return SummarizeExtrapolatedRegion(*camera, std::nullopt,
                                       SupportedBut(is_beyond), Lattice(1, 3))
        .image_regions;
  };
  EXPECT_EQ(image_regions([](const auto&) { return false; }), "");
  EXPECT_EQ(image_regions(IsInCorner), "corners");
  EXPECT_EQ(
      image_regions([](const auto& p) { return IsInCorner(p) && p.x() < 320; }),
      "top left and bottom left corners");
  EXPECT_EQ(image_regions([](const auto& p) { return p.x() < 60; }),
            "left edge");
  EXPECT_EQ(
      image_regions([](const auto& p) { return p.x() < 60 || p.y() > 420; }),
      "left and bottom edges");
  EXPECT_EQ(image_regions([](const auto& p) {
              return p.x() < 60 || (IsInCorner(p) && p.x() > 320);
            }),
            "left edge and top right and bottom right corners");
  EXPECT_EQ(image_regions([](const auto& p) {
              return std::min({p.x(), p.y(), 640 - p.x(), 480 - p.y()}) < 60;
            }),
            "edges");
}

TEST(UncertaintySummary, SaysHowMuchExtrapolationMayErr) {
  const ExtrapolatedRegion region = SummarizeExtrapolatedRegion(
      *Camera(), std::nullopt,
      SupportedBut([](const auto& p) { return p.x() > 576; }), Lattice(1, 3));
  EXPECT_NEAR(region.share, 0.1, 0.01);
  EXPECT_NEAR(region.p95_px, 2.98, 0.05);
}

}  // namespace
}  // namespace raygrid
