#include "capture/rig_guide.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/board_view.h"
#include "initialization/localization.h"
#include "simulation/random.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

// Two cameras of one kind, the second aside and turned, before one board.
class GuidedRig : public testing::Test {
 protected:
  static Pose TrueSecondFromFirst() {
    return {RotationFromVector({0.01, -0.15, 0.02}), {-0.12, 0.01, 0.02}};
  }

  RigGuide Guide(bool skip_connecting_views = false) {
    options_.skip_connecting_views = skip_connecting_views;
    std::vector<GuidedCamera> cameras;
    for (size_t c = 0; c < live_.size(); ++c) {
      const auto count = static_cast<int>(live_[c].images().images.size());
      if (!guides_[c] || guides_[c]->num_images() != count)
        guides_[c] =
            std::make_shared<CaptureGuide>(live_[c], pattern_, options_);
      cameras.push_back({&live_[c], guides_[c], {}});
    }
    return {cameras, pattern_, options_};
  }

  // The board's features in a camera, with noise.
  ImageFeatures See(const Pose& camera_from_board) {
    ImageFeatures image;
    image.image = std::to_string(num_instants_);
    image.features = VisibleFeatures(lens_, board_, camera_from_board);
    AddNoise({}, &random_, &image.features);
    return image;
  }
  // Shows the view that is asked for to its camera alone, or to both.
  void Follow(const RigView& next, bool is_seen_by_both) {
    ++num_instants_;
    const Pose& pose = next.view.camera_from_board;
    live_[next.camera].Add(See(pose));
    if (!is_seen_by_both) return;
    const Pose to_other = next.camera == 0 ? TrueSecondFromFirst()
                                           : TrueSecondFromFirst().Inverse();
    const ImageFeatures other = See(to_other * pose);
    if (other.features.size() >= 12) live_[1 - next.camera].Add(other);
  }
  // How far the second camera sees a board from where the first one, as it was
  // adjusted, and the link predict it, RMS.
  double ErrorPx(const CameraLink& link) const {
    const Pose pose =
        *ComputePose({{340, 240}, 300, 0.3, 1, 0.2}, board_, lens_);
    const CameraModel& first = live_[0].adjusted()->state.camera();
    const CameraModel& second = live_[1].adjusted()->state.camera();
    std::vector<PointPixelMatch> matches;
    for (const Eigen::Vector3d& point : board_.points)
      if (const auto pixel = lens_.Project(pose * point))
        matches.push_back({point, *pixel});
    const auto located = Localize(first, matches);
    if (!located) return 1e9;
    double square = 0;
    int count = 0;
    for (const Eigen::Vector3d& point : board_.points) {
      const auto truth = lens_.Project(TrueSecondFromFirst() * (pose * point));
      const auto told =
          second.Project(link.second_from_first() * (*located * point));
      if (!truth || !told) continue;
      square += (*truth - *told).squaredNorm();
      ++count;
    }
    return count > 0 ? std::sqrt(square / count) : 1e9;
  }
  void FollowUntilBothAreKnown() {
    for (int k = 0; k < 12; ++k) {
      const RigGuide guide = Guide();
      if (guide.guide(0)->information() && guide.guide(1)->information())
        return;
      ASSERT_TRUE(guide.next());
      Follow(*guide.next(), false);
    }
    FAIL();
  }

  const Pattern pattern_ = TestBoard();
  const Board& board_ = pattern_.boards.front();
  const SimulatedCamera lens_ = ExampleSimulatedCamera();
  std::vector<LiveCamera> live_ =
      std::vector<LiveCamera>(2, LiveCamera(TestBoard(), {640, 480}, 2));
  std::vector<std::shared_ptr<const CaptureGuide>> guides_{2};
  GuideOptions options_;
  Random random_{3};
  int num_instants_ = 0;
};

TEST_F(GuidedRig, AsksForAViewOfBothOnceEachIsKnown) {
  EXPECT_FALSE(Guide().to_connect());
  FollowUntilBothAreKnown();
  const RigGuide guide = Guide();
  ASSERT_TRUE(guide.to_connect());
  EXPECT_EQ(*guide.to_connect(), std::make_pair(size_t{0}, size_t{1}));
  EXPECT_FALSE(guide.next());
  EXPECT_FALSE(guide.is_done());
  EXPECT_TRUE(guide.links().empty());
  // In vain: each camera goes on by itself.
  EXPECT_TRUE(Guide(true).next());

  const BoardView view = {{380, 240}, 250, 0.3, 1, 0.2};
  const Pose pose = *ComputePose(view, board_, lens_);
  ++num_instants_;
  const ImageFeatures first = See(pose);
  const ImageFeatures second = See(TrueSecondFromFirst() * pose);
  EXPECT_FALSE(guide.IsInformativeForLinks({&first, nullptr}));
  EXPECT_TRUE(guide.IsInformativeForLinks({&first, &second}));
  live_[0].Add(first);
  live_[1].Add(second);
  const RigGuide connected = Guide();
  EXPECT_FALSE(connected.to_connect());
  ASSERT_EQ(connected.links().size(), 1u);
  // That view once more tells of noise alone.
  EXPECT_FALSE(connected.IsInformativeForLinks({&first, &second}));
}

TEST_F(GuidedRig, LeadsToARigThatIsKnown) {
  options_.target_px = 0.15;
  int num_steps = 0;
  for (; num_steps < 60; ++num_steps) {
    const RigGuide guide = Guide(num_steps > 40);
    if (guide.is_done()) break;
    if (guide.to_connect() && !guide.next()) {
      const Pose pose =
          *ComputePose({{380, 240}, 250, 0.3, 1, 0.2}, board_, lens_);
      Follow({0, {&board_, pose, 1}}, true);
      continue;
    }
    ASSERT_TRUE(guide.next());
    Follow(*guide.next(), true);
  }
  const RigGuide guide = Guide();
  EXPECT_TRUE(guide.is_done()) << num_steps;
  ASSERT_EQ(guide.links().size(), 1u);
  const CameraLink& link = guide.links()[0].link;
  EXPECT_LE(link.RmsPx(), 0.15);
  for (int c = 0; c < 2; ++c)
    EXPECT_LE(guide.guide(c)->information()->Percentile95Px(), 0.15);
  EXPECT_LT(ErrorPx(link), 0.2);
}

// The prediction of a link's error is what its error is.
TEST_F(GuidedRig, TellsHowWellALinkIsKnown) {
  double sum = 0, predicted = 0;
  constexpr int kTrials = 4;
  for (int trial = 0; trial < kTrials; ++trial) {
    live_ = std::vector<LiveCamera>(2, LiveCamera(TestBoard(), {640, 480}, 2));
    for (int k = 0; k < 16; ++k) {
      const Pose pose =
          *ComputePose({{300.0 + 40 * (k % 4), 160.0 + 50 * (k / 4)},
                        300,
                        0.5,
                        1.3 * k,
                        0.2 * k},
                       board_, lens_);
      Follow({0, {&board_, pose, 1}}, true);
    }
    const auto link = CameraLink::Of(live_[0], live_[1]);
    ASSERT_TRUE(link);
    predicted += link->RmsPx() * link->RmsPx();
    const double error_px = ErrorPx(*link);
    sum += error_px * error_px;
  }
  // Scatter tells nothing of an error that all boards share.
  const double ratio = std::sqrt(sum / predicted);
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 4);
}

}  // namespace
}  // namespace raygrid
