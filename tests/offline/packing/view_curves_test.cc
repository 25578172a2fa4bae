#include "packing/view_curves.h"

#include "packed_cameras.h"

namespace raygrid {
namespace {

constexpr ImageSize kCurvesSize = {640, 480};

VirtualView PlainView(ViewProjection projection, double focal_px) {
  VirtualView view;
  view.size = kCurvesSize;
  view.projection = projection;
  view.focal_px = {focal_px, focal_px};
  view.center_px = {319.5, 239.5};
  return view;
}

double Spread(const PixelCurve& curve, int axis) {
  double low = INFINITY, high = -INFINITY;
  for (const Eigen::Vector2d& pixel : curve) {
    low = std::min(low, pixel[axis]);
    high = std::max(high, pixel[axis]);
  }
  return high - low;
}

// The distance of the farthest point from the line through the ends.
double Bow(const PixelCurve& curve) {
  const Eigen::Vector2d along = (curve.back() - curve.front()).normalized();
  double worst = 0;
  for (const Eigen::Vector2d& pixel : curve) {
    const Eigen::Vector2d from_start = pixel - curve.front();
    worst = std::max(worst, std::abs(along.x() * from_start.y() -
                                     along.y() * from_start.x()));
  }
  return worst;
}

TEST(MakeRoomLines, AreStraightInAPinhole) {
  const VirtualView view = PlainView(ViewProjection::kPinhole, 600);
  const auto level = MakeRoomLines(view, Eigen::Matrix3d::Identity(), 0.125);
  EXPECT_GT(level.size(), 12u);
  for (const PixelCurve& curve : level)
    EXPECT_LT(std::min(Spread(curve, 0), Spread(curve, 1)), 1e-9);
  // A turned room's wall still fills the view, and its lines run at an angle.
  const Eigen::Matrix3d turned = RotationFromAngles({8, 5, 20});
  for (const PixelCurve& curve : MakeRoomLines(view, turned, 0.125))
    EXPECT_LT(Bow(curve), 1e-8);
}

TEST(MakeRoomLines, ReachFromEdgeToEdgeOfANarrowView) {
  const VirtualView view = PlainView(ViewProjection::kPinhole, 640 / 0.035);
  const auto curves = MakeRoomLines(view, Eigen::Matrix3d::Identity(),
                                    ComputeViewSquareSize(view));
  ASSERT_GT(curves.size(), 2u);
  for (const PixelCurve& curve : curves)
    EXPECT_GT(std::max(Spread(curve, 0) - 640, Spread(curve, 1) - 480), 0);
}

TEST(MakeRoomLines, AreBentWhereTheProjectionBendsThem) {
  const auto curves =
      MakeRoomLines(PlainView(ViewProjection::kCylindrical, 300),
                    Eigen::Matrix3d::Identity(), 0.25);
  double most = 0;
  int num_upright = 0;  // strokes
  for (const PixelCurve& curve : curves) {
    most = std::max(most, Bow(curve));
    for (size_t k = 1; k < curve.size(); ++k)
      num_upright += std::abs(curve[k].x() - curve[k - 1].x()) < 1e-9;
  }
  EXPECT_GT(most, 10);
  // Lines that stand upright in the room still do.
  EXPECT_GT(num_upright, 1000);
}

TEST(MakeRoomLines, DoNotCrossTheImageWhereItsSidesMeet) {
  VirtualView view = PlainView(ViewProjection::kEquirectangular, 640 / 6.2832);
  const auto curves = MakeRoomLines(view, Eigen::Matrix3d::Identity(), 0.25);
  EXPECT_GT(curves.size(), 20u);
  for (const PixelCurve& curve : curves)
    for (size_t k = 1; k < curve.size(); ++k)
      EXPECT_LE((curve[k] - curve[k - 1]).norm(), 160);
}

TEST(ComputeValidOutline, GoesAroundTrustedCells) {
  ValidityMask mask;
  mask.knot_spacing_px = 16;
  mask.columns = 3;
  mask.rows = 2;
  mask.is_valid = {false, true, false, false, false, false};
  const auto one = ComputeValidOutline(mask, {40, 30});
  ASSERT_EQ(one.size(), 4u);
  for (const PixelCurve& edge : one)
    for (const Eigen::Vector2d& pixel : edge)
      EXPECT_TRUE((Area{15.5, -0.5, 31.5, 15.5}.Contains(pixel)));
  // The last cells end with the image.
  mask.is_valid.assign(6, true);
  double right = 0, low = 0;
  const auto all = ComputeValidOutline(mask, {40, 30});
  EXPECT_EQ(all.size(), 10u);
  for (const PixelCurve& edge : all)
    for (const Eigen::Vector2d& pixel : edge) {
      right = std::max(right, pixel.x());
      low = std::max(low, pixel.y());
    }
  EXPECT_EQ(right, 39.5);
  EXPECT_EQ(low, 29.5);
  mask.is_valid.assign(6, false);
  EXPECT_TRUE(ComputeValidOutline(mask, {40, 30}).empty());
}

TEST(ProjectCurves, LieWhereTheViewShowsThePixels) {
  const CameraModel& camera = *GenericFile().camera;
  const VirtualView view = Virtual();
  const auto curves = ProjectCurves(camera, view, {{{200, 150}, {260, 150}}});
  ASSERT_EQ(curves.size(), 1u);
  for (const Eigen::Vector2d& pixel : curves[0]) {
    const auto back = camera.Project(*view.Direction(pixel));
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->y(), 150, 1e-6);
  }
  // Pixels that the view does not show are left out.
  const VirtualView narrow = ViewOf(camera, {640, 480}, 5);
  EXPECT_TRUE(ProjectCurves(camera, narrow, {{{10, 10}, {20, 10}}}).empty());
}

TEST(ComputeViewEdge, IsThatOfTheImageItself) {
  const VirtualView view = PlainView(ViewProjection::kPinhole, 500);
  const std::unique_ptr<CameraModel> same = MakeViewCamera(view);
  VirtualView half = view;
  half.focal_px *= 2;
  Eigen::AlignedBox2d box;
  for (const PixelCurve& curve : ComputeViewEdge(*same, half))
    for (const Eigen::Vector2d& pixel : curve) box.extend(pixel);
  EXPECT_LT((box.min() - Eigen::Vector2d(159.5, 119.5)).norm(), 0.01);
  EXPECT_LT((box.max() - Eigen::Vector2d(479.5, 359.5)).norm(), 0.01);
}

}  // namespace
}  // namespace raygrid
