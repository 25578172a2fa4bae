#include "capture/capture_guide.h"

#include <algorithm>

#include "capture/board_outline.h"
#include "capture/board_view.h"
#include "capture/keyframe_selector.h"
#include "capture/view_hint.h"
#include "evaluation/min_images.h"
#include "simulation/random.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr ImageSize kGuidedSize = {640, 480};

// A person who holds the board where the guide wants it.
class GuidedCapture {
 public:
  explicit GuidedCapture(const GuideOptions& options)
      : options_(options), live_(TestBoard(), kGuidedSize, 2) {}

  CaptureGuide Guide() const { return {live_, TestBoard(), options_}; }
  // The view asked for, in pixels of the true camera.
  ImageFeatures Follow(const CaptureGuide& guide) {
    ImageFeatures image;
    image.image = std::to_string(num_seen_++);
    image.features = VisibleFeatures(camera_, *guide.next()->board,
                                     guide.next()->camera_from_board);
    AddNoise({}, &random_, &image.features);
    return image;
  }
  void Add(const ImageFeatures& image) { live_.Add(image); }
  LiveCamera& live() { return live_; }

 private:
  const GuideOptions options_;
  const SimulatedCamera camera_ = ExampleSimulatedCamera();
  LiveCamera live_;
  Random random_{3};
  int num_seen_ = 0;
};

TEST(CaptureGuide, LeadsToACameraThatIsKnown) {
  GuideOptions options;
  options.target_px = 0.07;
  GuidedCapture capture(options);
  int num_images = 0;
  std::optional<int> expected;
  for (; num_images < 30; ++num_images) {
    const CaptureGuide guide = capture.Guide();
    if (guide.is_done()) break;
    ASSERT_TRUE(guide.next());
    if (num_images == 6) expected = guide.num_expected();
    const ImageFeatures image = capture.Follow(guide);
    EXPECT_TRUE(guide.IsNextView(image)) << num_images;
    EXPECT_TRUE(guide.ShouldKeep(guide.ComputeGain(image), true)) << num_images;
    capture.Add(image);
  }
  const CaptureGuide guide = capture.Guide();
  EXPECT_TRUE(guide.is_done());
  EXPECT_FALSE(guide.next());
  EXPECT_EQ(guide.num_expected(), 0);
  ASSERT_TRUE(guide.information());
  EXPECT_LE(guide.information()->Percentile95Px(), 0.07);
  ASSERT_TRUE(expected);
  EXPECT_LT(std::abs(*expected - (num_images - 6)), 6);
}

// However little is asked for: few images leave too much open.
TEST(CaptureGuide, IsNotDoneBeforeACalibrationHasEnoughImages) {
  GuideOptions options;
  options.target_px = 5;
  GuidedCapture capture(options);
  for (int num_images = 0; num_images < kMinReliableImages; ++num_images) {
    const CaptureGuide guide = capture.Guide();
    EXPECT_TRUE(guide.is_floor());
    ASSERT_FALSE(guide.is_done()) << num_images;
    ASSERT_TRUE(guide.next());
    const ImageFeatures image = capture.Follow(guide);
    EXPECT_TRUE(guide.ShouldKeep(guide.ComputeGain(image), true)) << num_images;
    if (const auto expected = guide.num_expected())
      EXPECT_GE(*expected, kMinReliableImages - num_images);
    capture.Add(image);
  }
  EXPECT_FALSE(capture.Guide().is_floor());
  EXPECT_TRUE(capture.Guide().is_done());
}

TEST(CaptureGuide, KeepsNoViewTwice) {
  GuidedCapture capture({});
  // While nothing is known, and later.
  for (int k = 0; k < 5; ++k) {
    const CaptureGuide guide = capture.Guide();
    const ImageFeatures image = capture.Follow(guide);
    capture.Add(image);
    const CaptureGuide next = capture.Guide();
    EXPECT_FALSE(next.IsNextView(image)) << k;
    EXPECT_FALSE(next.ShouldKeep(next.ComputeGain(image), false)) << k;
  }
}

TEST(CaptureGuide, ForgetsAnImageThatIsRemoved) {
  GuidedCapture capture({});
  for (int k = 0; k < 5; ++k) capture.Add(capture.Follow(capture.Guide()));
  const CaptureGuide before = capture.Guide();
  const double before_px = before.information()->Percentile95Px();
  const ImageFeatures image = capture.Follow(before);
  capture.Add(image);
  EXPECT_LT(capture.Guide().information()->Percentile95Px(), before_px);
  capture.live().Remove(image.image);
  const CaptureGuide after = capture.Guide();
  EXPECT_EQ(after.num_images(), 5);
  EXPECT_NEAR(after.information()->Percentile95Px(), before_px,
              0.2 * before_px);
}

// ---- Outlines ---------------------------------------------------------------

TEST(BoardOutline, LiesWhereTheCameraSeesTheBoard) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  const Pose pose = *ComputePose({{320, 240}, 300, 0.5, 1, 0.3}, board, camera);
  const std::vector<Eigen::Vector2d> outline =
      ProjectOutline(camera, board, pose);
  const std::vector<Eigen::Vector3d> points = OutlinePoints(board);
  ASSERT_EQ(outline.size(), points.size());
  EXPECT_EQ(points[kOutlineSteps], board.points[board.columns - 1]);
  for (size_t k = 0; k < points.size(); ++k)
    EXPECT_LT((outline[k] - *camera.Project(pose * points[k])).norm(), 1e-9);
}

// A board that is larger than the image.
TEST(BoardOutline, GoesOnBeyondTheImage) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  const Pose pose = *ComputePose({{500, 300}, 700, 0.4, 2, 0}, board, camera);
  const std::vector<Eigen::Vector2d> outline =
      ProjectOutline(camera, board, pose);
  ASSERT_EQ(outline.size(), 4u * kOutlineSteps);
  const Eigen::Vector2d& left_top = outline.front();
  const Eigen::Vector2d& right_low = outline[2 * kOutlineSteps];
  EXPECT_GT(right_low.x(), 640);
  EXPECT_GT(right_low.x() - left_top.x(), 500);
  for (size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d& next = outline[(k + 1) % outline.size()];
    EXPECT_LT((next - outline[k]).norm(), 200) << k;
  }
}

// ---- Judging ----------------------------------------------------------------

class JudgedCapture {
 public:
  JudgedCapture() : guide_(GuidedCapture({}).Guide()) {
    GuidedCapture capture({});
    frame_.features = capture.Follow(guide_);
    frame_.quality.min_spread_px = frame_.quality.max_spread_px = 0.8;
    frame_.quality.white = 200;
    frame_.quality.black = 20;
  }
  DetectedFrame frame() const { return frame_; }
  DetectedFrame At(double time_s, double shift_px) const {
    DetectedFrame moved = frame_;
    moved.time_s = time_s;
    for (Feature& feature : moved.features.features)
      feature.pixel.x() += shift_px;
    return moved;
  }
  std::string Word(const DetectedFrame& frame) {
    return GetStatusText(judge_.Assess(frame, guide_));
  }

 private:
  const CaptureGuide guide_;
  DetectedFrame frame_;
  KeyframeSelector judge_{{}};
};

TEST(KeyframeSelector, SaysWhatIsWrongInAWord) {
  JudgedCapture capture;
  EXPECT_EQ(capture.Word(capture.frame()), "kept");
  DetectedFrame frame = capture.frame();
  frame.features.features.resize(5);
  EXPECT_EQ(capture.Word(frame), "few");
  frame.features.features.clear();
  EXPECT_EQ(capture.Word(frame), "absent");
  frame = capture.frame();
  frame.quality.white = 40;
  EXPECT_EQ(capture.Word(frame), "dark");
  frame = capture.frame();
  frame.quality.clipped = 0.5;
  EXPECT_EQ(capture.Word(frame), "bright");
  frame = capture.frame();
  frame.quality.max_spread_px = 2;  // in one direction
  EXPECT_EQ(capture.Word(frame), "moving");
  frame.quality.min_spread_px = 2;
  EXPECT_EQ(capture.Word(frame), "blurred");
  EXPECT_EQ(capture.Word(capture.frame()), "kept");
}

TEST(KeyframeSelector, TakesASoftLensAsItIs) {
  JudgedCapture capture;
  DetectedFrame frame = capture.frame();
  frame.quality.min_spread_px = frame.quality.max_spread_px = 2.5;
  EXPECT_EQ(capture.Word(frame), "kept");
}

TEST(KeyframeSelector, WantsFeaturesToStandStill) {
  JudgedCapture capture;
  EXPECT_EQ(capture.Word(capture.At(0, 0)), "kept");
  EXPECT_EQ(capture.Word(capture.At(1 / 30.0, 0.2)), "kept");
  EXPECT_EQ(capture.Word(capture.At(2 / 30.0, 0.6)), "moving");
  // Features that move as fast, seen less often.
  EXPECT_EQ(capture.Word(capture.At(5 / 30.0, 1.8)), "moving");
  EXPECT_EQ(capture.Word(capture.At(8 / 30.0, 2.4)), "kept");
  // A short exposure stops what is faster.
  DetectedFrame frame = capture.At(9 / 30.0, 4.4);
  frame.exposure_s = 0.002;
  EXPECT_EQ(capture.Word(frame), "kept");
}

TEST(KeyframeSelector, WaitsWhenABoardComes) {
  JudgedCapture capture;
  DetectedFrame without = capture.At(0, 0);
  without.features.features.clear();
  EXPECT_EQ(capture.Word(without), "absent");
  EXPECT_EQ(capture.Word(capture.At(0.03, 0)), "moving");
  EXPECT_EQ(capture.Word(capture.At(0.07, 0)), "kept");
}

// ---- Hints ------------------------------------------------------------------

std::string HintFrom(const BoardView& from, const BoardView& to) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  return DescribeMove(camera, board, *ComputePose(from, board, camera),
                      *ComputePose(to, board, camera));
}

TEST(ViewHint, SaysHowToMoveABoard) {
  const BoardView facing = {{320, 240}, 300, 0, 0, 0};
  EXPECT_EQ(HintFrom(facing, facing), "hold still");
  EXPECT_EQ(HintFrom(facing, {{500, 240}, 300, 0, 0, 0}), "right");
  EXPECT_EQ(HintFrom(facing, {{320, 120}, 300, 0, 0, 0}), "up");
  EXPECT_EQ(HintFrom(facing, {{320, 240}, 450, 0, 0, 0}), "closer");
  EXPECT_EQ(HintFrom(facing, {{320, 240}, 150, 0, 0, 0}), "farther");
  EXPECT_EQ(HintFrom(facing, {{320, 240}, 300, 0, 0, M_PI / 2}),
            "rotate clockwise");
}

// The side that is said to go away is then farther from the camera.
TEST(ViewHint, NamesTheSideThatGoesAway) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  const BoardView facing = {{320, 240}, 300, 0, 0, 0};
  for (const double axis_rad : {0.0, M_PI / 2, M_PI, 3 * M_PI / 2}) {
    const BoardView tilted = {{320, 240}, 300, 0.5, axis_rad, 0};
    const Pose pose = *ComputePose(tilted, board, camera);
    const auto z = [&](int column, int row) {
      return (pose * board.points[board.PointIndex(column, row)]).z();
    };
    const double rightwards = z(board.columns - 1, 0) - z(0, 0);
    const double downwards = z(0, board.rows - 1) - z(0, 0);
    const std::string side = std::abs(rightwards) > std::abs(downwards)
                                 ? (rightwards > 0 ? "right" : "left")
                                 : (downwards > 0 ? "bottom" : "top");
    EXPECT_EQ(HintFrom(facing, tilted), "tilt the " + side + " away");
  }
}

TEST(ViewHint, SaysTheLargestMovesFirst) {
  EXPECT_EQ(HintFrom({{320, 240}, 150, 0, 0, 0}, {{390, 240}, 450, 0, 0, 0}),
            "closer, right");
}

}  // namespace
}  // namespace raygrid
