// Pairs of cameras whose views have common rows.
#include "packing/rectification.h"

#include <opencv2/calib3d.hpp>

#include "camera/equivalent_central_camera.h"
#include "packed_cameras.h"
#include "simulation/noncentral_simulated_camera.h"

namespace raygrid {
namespace {

constexpr ImageSize kPairSize = {640, 480};

OpenCvModel PlainLens(const ImageSize& size, double focal_px) {
  OpenCvModel::ParameterArray p = {};
  p[OpenCvModel::kFx] = p[OpenCvModel::kFy] = focal_px;
  p[OpenCvModel::kCx] = (size.width - 1) / 2.0;
  p[OpenCvModel::kCy] = (size.height - 1) / 2.0;
  return OpenCvModel(size, WholeImage(size), p);
}
OpenCvModel BentLens(const ImageSize& size, double focal_px) {
  OpenCvModel lens = PlainLens(size, focal_px);
  Eigen::VectorXd parameters = lens.Parameters();
  parameters[OpenCvModel::kK1] = -0.1;
  lens.SetParameters(parameters);
  return lens;
}

// The pose of a camera that stands at a place of the rig, turned by a vector.
Pose StandingAt(const Eigen::Vector3d& place, const Eigen::Vector3d& turn) {
  const Eigen::Quaterniond rotation = RotationFromVector(turn).conjugate();
  return {rotation, -(rotation * place)};
}

struct TestPair {
  std::shared_ptr<const CameraModel> first, second;
  Pose first_from_rig, second_from_rig;

  Rectification Rectified(double alpha = 0, const ImageSize& size = {0, 0},
                          bool is_swapped = false) const {
    const StereoCamera a = {"a", *first, first_from_rig};
    const StereoCamera b = {"b", *second, second_from_rig};
    return is_swapped ? Rectify(b, a, {size, alpha, {}})
                      : Rectify(a, b, {size, alpha, {}});
  }
};

TestPair PairAt(const Eigen::Vector3d& place, const Eigen::Vector3d& turn) {
  return {std::make_shared<OpenCvModel>(BentLens(kPairSize, 400)),
          std::make_shared<OpenCvModel>(BentLens({500, 400}, 310)),
          StandingAt({0.4, 0.1, 0}, {0.03, 0.02, -0.05}),
          StandingAt(Eigen::Vector3d(0.4, 0.1, 0) + place, turn)};
}
TestPair SideBySide() {
  return PairAt({0.12, 0.01, -0.02}, {0.05, -0.06, 0.1});
}

// The places in both views of a point of the rig, if both cameras see it.
struct SeenTwice {
  Eigen::Vector2d first, second;
  Eigen::Vector3d in_first_view;
};
std::optional<SeenTwice> SeeTwice(const TestPair& pair,
                                  const Rectification& rectified,
                                  const Eigen::Vector3d& point) {
  const Eigen::Vector3d a = pair.first_from_rig * point;
  const Eigen::Vector3d b = pair.second_from_rig * point;
  const auto pixel_a = pair.first->Project(a);
  const auto pixel_b = pair.second->Project(b);
  if (!pixel_a || !pixel_b) return std::nullopt;
  return SeenTwice{*rectified.views[0].Pixel(*pair.first->Unproject(*pixel_a)),
                   *rectified.views[1].Pixel(*pair.second->Unproject(*pixel_b)),
                   rectified.R(0) * a};
}

// Calls check(SeenTwice) for points before both cameras.
template <typename Check>
void ForPointsSeenTwice(const TestPair& pair, const Rectification& rectified,
                        const Check& check) {
  TestRandom random(5);
  int num_seen = 0;
  for (int k = 0; k < 300; ++k) {
    const double z = random.Uniform(0.4, 5);
    const auto seen = SeeTwice(pair, rectified,
                               {0.5 + z * random.Uniform(-0.6, 0.6),
                                z * random.Uniform(-0.5, 0.5), z});
    if (!seen) continue;
    ++num_seen;
    check(*seen);
  }
  EXPECT_GT(num_seen, 60);
}

// P projects the point, and Q finds it again.
void ExpectMatricesOf(const Rectification& rectified, const SeenTwice& seen,
                      double disparity) {
  const Eigen::Vector3d of_second =
      rectified.P(1) * seen.in_first_view.homogeneous();
  EXPECT_LT((of_second.hnormalized() - seen.second).norm(), 1e-6);
  const Eigen::Vector4d back =
      rectified.Q() *
      Eigen::Vector4d(seen.first.x(), seen.first.y(), disparity, 1);
  EXPECT_LT((back.hnormalized() - seen.in_first_view).norm(), 1e-6);
}

TEST(Rectify, PointsKeepTheirRow) {
  const TestPair pair = SideBySide();
  const Rectification rectified = pair.Rectified();
  EXPECT_FALSE(rectified.is_vertical);
  EXPECT_NEAR(rectified.baseline_m, Eigen::Vector3d(0.12, 0.01, -0.02).norm(),
              1e-12);
  EXPECT_EQ(rectified.views[0].focal_px, rectified.views[1].focal_px);
  EXPECT_EQ(rectified.views[0].center_px, rectified.views[1].center_px);
  EXPECT_EQ(rectified.views[0].size, kPairSize);
  ForPointsSeenTwice(pair, rectified, [&](const SeenTwice& seen) {
    EXPECT_NEAR(seen.first.y(), seen.second.y(), 1e-6);
    const double disparity = seen.first.x() - seen.second.x();
    EXPECT_NEAR(disparity,
                rectified.views[0].focal_px.x() * rectified.baseline_m /
                    seen.in_first_view.z(),
                1e-6);
    ExpectMatricesOf(rectified, seen, disparity);
  });
}

TEST(Rectify, PointsOfAVerticalPairKeepTheirColumn) {
  const TestPair pair = PairAt({0.01, 0.15, 0.02}, {-0.05, 0.06, 0.1});
  const Rectification rectified = pair.Rectified();
  EXPECT_TRUE(rectified.is_vertical);
  ForPointsSeenTwice(pair, rectified, [&](const SeenTwice& seen) {
    EXPECT_NEAR(seen.first.x(), seen.second.x(), 1e-6);
    const double disparity = seen.first.y() - seen.second.y();
    EXPECT_GT(disparity, 0);
    ExpectMatricesOf(rectified, seen, disparity);
  });
}

TEST(Rectify, MatricesAreWrittenAsOpenCvWritesThem) {
  TestPair pair = SideBySide();
  pair.second = pair.first;
  const Rectification rectified = pair.Rectified(0);
  const Pose second_from_first =
      pair.second_from_rig * pair.first_from_rig.Inverse();
  const Eigen::Matrix3d rotation =
      second_from_first.rotation.toRotationMatrix();
  cv::Matx33d r, k(400, 0, 319.5, 0, 400, 239.5, 0, 0, 1), r1, r2;
  for (int i = 0; i < 9; ++i) r.val[i] = rotation(i / 3, i % 3);
  const Eigen::Vector3d& t = second_from_first.translation;
  cv::Matx34d p1, p2;
  cv::Matx44d q;
  const cv::Vec<double, 5> d(-0.1, 0, 0, 0, 0);
  cv::stereoRectify(k, d, k, d, {640, 480}, r, cv::Vec3d(t.x(), t.y(), t.z()),
                    r1, r2, p1, p2, q);
  // Turned alike but for the mean of the axes, which is not the mean rotation.
  const auto angle_rad = [&](const cv::Matx33d& theirs, int camera) {
    Eigen::Matrix3d other;
    for (int i = 0; i < 9; ++i) other(i / 3, i % 3) = theirs.val[i];
    return Eigen::AngleAxisd(other.transpose() * rectified.R(camera)).angle();
  };
  EXPECT_LT(angle_rad(r1, 0), 0.02);
  EXPECT_NEAR(angle_rad(r1, 0), angle_rad(r2, 1), 1e-9);
  EXPECT_NEAR(p2(0, 3) / p2(0, 0), rectified.P(1)(0, 3) / rectified.P(1)(0, 0),
              1e-12);
  EXPECT_NEAR(q(3, 2), rectified.Q()(3, 2), 1e-9);
  EXPECT_NEAR(q(3, 3), 0, 1e-12);
  EXPECT_EQ(q(2, 3), p1(0, 0));
  EXPECT_EQ(q(0, 3), -p1(0, 2));
  EXPECT_EQ(rectified.Q()(0, 3), -rectified.P(0)(0, 2));
  EXPECT_EQ(rectified.Q()(1, 3), -rectified.P(0)(1, 2));
}

TEST(Rectify, TheAxisIsTheMeanOfTheCamerasAxes) {
  const TestPair pair = SideBySide();
  const Rectification rectified = pair.Rectified();
  // It is as far from one as from the other, seen along the baseline.
  const Eigen::Vector3d a = rectified.R(0).col(2), b = rectified.R(1).col(2);
  EXPECT_NEAR(a.y(), -b.y(), 1e-9);
  EXPECT_GT(a.z(), 0.98);
}

TEST(Rectify, AlphaZeroHasNoBorderInEitherImage) {
  const TestPair pair = SideBySide();
  for (const ImageSize& size : {kPairSize, ImageSize{300, 400}}) {
    const Rectification rectified = pair.Rectified(0, size);
    EXPECT_EQ(rectified.views[0].size, size);
    bool is_at_border = false;
    for (const int c : {0, 1}) {
      const CameraModel& camera = c == 0 ? *pair.first : *pair.second;
      const VirtualView& view = rectified.views[c];
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
          const auto source = camera.Project(*view.Direction({x, y}));
          ASSERT_TRUE(source);
          is_at_border |= !camera.area().Contains(*source, -1);
        }
    }
    EXPECT_TRUE(is_at_border);  // none is larger
  }
}

TEST(Rectify, AlphaOneShowsEveryPixelOfBoth) {
  const TestPair pair = SideBySide();
  const Rectification rectified = pair.Rectified(1);
  const Area image = WholeImage(rectified.views[0].size);
  bool is_at_edge = false;
  for (const int c : {0, 1}) {
    const CameraModel& camera = c == 0 ? *pair.first : *pair.second;
    const Area& area = camera.area();
    for (int k = 0; k <= 400; ++k)
      for (const Eigen::Vector2d& part :
           {Eigen::Vector2d(k / 400.0, 0), Eigen::Vector2d(k / 400.0, 1),
            Eigen::Vector2d(0, k / 400.0), Eigen::Vector2d(1, k / 400.0)}) {
        const auto pixel = rectified.views[c].Pixel(
            *camera.Unproject({area.x0 + part.x() * area.width(),
                               area.y0 + part.y() * area.height()}));
        ASSERT_TRUE(pixel && image.Contains(*pixel, 0.01));
        is_at_edge |= !image.Contains(*pixel, -2);
      }
  }
  EXPECT_TRUE(is_at_edge);
  // Focal lengths in between are so.
  EXPECT_NEAR(pair.Rectified(0.25).views[0].focal_px.x(),
              0.75 * pair.Rectified(0).views[0].focal_px.x() +
                  0.25 * rectified.views[0].focal_px.x(),
              1e-9);
}

TEST(Rectify, TellsWhatBothSee) {
  TestPair pair = SideBySide();
  pair.second = pair.first;
  pair.second_from_rig = pair.first_from_rig * Pose{};
  pair.second_from_rig.translation.x() -= 0.1;
  EXPECT_EQ(pair.Rectified().overlap, 1);
  EXPECT_NEAR(pair.Rectified().angle_deg, 0, 1e-6);
  EXPECT_LT(SideBySide().Rectified().overlap, 0.99);
}

TEST(Rectify, NoticesCamerasNamedTheWrongWayAround) {
  const TestPair beside = SideBySide();
  ExpectError(ExitCode::kUsage,
              {"b is to the right of a", "--left a --right b"}, [&] {
                beside.Rectified(0, {0, 0}, true);
              });
  const TestPair above = PairAt({0.01, 0.15, 0.02}, {-0.05, 0.06, 0.1});
  ExpectError(ExitCode::kUsage, {"b is below a", "--left a --right b"}, [&] {
    above.Rectified(0, {0, 0}, true);
  });
  const Pose b_from_a =
      beside.second_from_rig * beside.first_from_rig.Inverse();
  EXPECT_FALSE(IsOrderReversed(b_from_a));
  EXPECT_TRUE(IsOrderReversed(b_from_a.Inverse()));
}

TEST(Rectify, TurnsACameraThatIsMountedUpsideDown) {
  const TestPair pair = PairAt({0.12, 0, 0}, {0, 0, M_PI - 0.01});
  const Rectification rectified = pair.Rectified();
  EXPECT_FALSE(rectified.is_vertical);
  EXPECT_GT(rectified.R(0)(0, 0), 0.9);
  ForPointsSeenTwice(pair, rectified, [&](const SeenTwice& seen) {
    EXPECT_NEAR(seen.first.y(), seen.second.y(), 1e-6);
    EXPECT_GT(seen.first.x() - seen.second.x(), 0);
  });
}

TEST(Rectify, RefusesPairsThatNoTwoImagesShow) {
  const auto expect_refused = [](const TestPair& pair, double alpha,
                                 const std::vector<std::string>& words) {
    ExpectError(ExitCode::kUsage, words, [&] { pair.Rectified(alpha); });
  };
  expect_refused(PairAt({0, 0, 0}, {0, 0, 0.1}), 0, {"a and b", "no baseline"});
  expect_refused(PairAt({0.1, 0, 0}, {0, 2.5, 0}), 0, {"do not overlap"});
  expect_refused(PairAt({0.1, 0, 0}, {0, 2.5, 0}), 1, {"do not overlap"});
  expect_refused(PairAt({0, 0.01, 0.3}, {0, 0, 0}), 0, {"epipoles"});
  expect_refused(SideBySide(), 1.5, {"alpha 1.5"});
  expect_refused(SideBySide(), -0.1, {"alpha -0.1"});
  TestPair wide = SideBySide();
  wide.first = wide.second = MakeSimulatedCamera("fisheye190", kPairSize);
  expect_refused(wide, 1, {"alpha 1", "alpha 0 or hfov"});
}

TEST(Rectify, ShowsAsMuchOfFisheyesAsIsOfUse) {
  TestPair wide = SideBySide();
  wide.first = wide.second = MakeSimulatedCamera("fisheye190", kPairSize);
  EXPECT_NEAR(wide.Rectified(0).views[0].HorizontalFieldOfViewDeg(), 140, 2);
  const Rectification usual =
      Rectify({"a", *wide.first, wide.first_from_rig},
              {"b", *wide.second, wide.second_from_rig}, {});
  EXPECT_NEAR(usual.views[0].HorizontalFieldOfViewDeg(), 120, 2);
  EXPECT_EQ(usual.views[0].center_px, usual.views[1].center_px);
}

TEST(Rectify, CamerasOfLinesKeepRowsAtTheirDistance) {
  constexpr double kDistanceM = 0.6;
  const auto lens =
      std::make_shared<MovingPupilCamera>(BentLens(kPairSize, 400), 0.02);
  const auto at_distance =
      std::make_shared<EquivalentCentralCamera>(*lens, kDistanceM);
  TestPair pair = SideBySide();
  pair.first = pair.second = at_distance;
  const Rectification rectified = pair.Rectified();
  // The middle between the cameras, from which points are equally far.
  TestRandom random(2);
  double worst_px = 0, worst_far_px = 0;
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d in_view(rectified.baseline_m / 2,
                                  random.Uniform(-0.2, 0.2), 1);
    const double scale = kDistanceM / in_view.norm();
    for (const double far : {1.0, 20.0}) {
      const Eigen::Vector3d at(rectified.baseline_m / 2,
                               far * scale * in_view.y(), far * scale);
      const Eigen::Vector3d moved =
          at - Eigen::Vector3d(rectified.baseline_m, 0, 0);
      const auto a = lens->Project(rectified.R(0).transpose() * at);
      const auto b = lens->Project(rectified.R(1).transpose() * moved);
      ASSERT_TRUE(a && b);
      const Eigen::Vector2d row_a =
          *rectified.views[0].Pixel(*at_distance->Unproject(*a));
      const Eigen::Vector2d row_b =
          *rectified.views[1].Pixel(*at_distance->Unproject(*b));
      double& worst = far == 1 ? worst_px : worst_far_px;
      worst = std::max(worst, std::abs(row_a.y() - row_b.y()));
    }
  }
  EXPECT_LT(worst_px, 0.1);
  EXPECT_GT(worst_far_px, 2 * worst_px);
}

}  // namespace
}  // namespace raygrid
