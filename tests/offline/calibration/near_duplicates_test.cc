// Images that show the same view count once.

#include "calibration/near_duplicates.h"

#include <algorithm>
#include <set>

#include "calibration/calibration.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "simulation/simulated_rig.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr ImageSize kSameViewsSize = {640, 480};

Dataset ViewsOf(int num_images, int num_shots = 1) {
  SimulationOptions options;
  options.num_images = num_images;
  options.num_shots = num_shots;
  options.features_per_image = 80;
  return SimulateObservations(ExampleSimulatedCamera(), TestBoard(), options)
      .dataset;
}

// A lattice of features, moved.
ImageFeatures Lattice(const std::string& name, double x, int board = 0) {
  ImageFeatures image = {name, {}};
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 8; ++column)
      image.features.push_back(
          {board, column, row, {100.0 + 20 * column + x, 100.0 + 20 * row}});
  return image;
}

ImageFeatures Joined(ImageFeatures image, const ImageFeatures& more) {
  image.features.insert(image.features.end(), more.features.begin(),
                        more.features.end());
  return image;
}

std::vector<NearDuplicates> Find(
    const std::vector<ImageFeatures>& images, double duplicate_px = 3,
    const std::vector<std::string>& held_out = {}) {
  return FindNearDuplicates({{kSameViewsSize, images}}, held_out, duplicate_px);
}

// Names in groups, as "a: b c; d: e".
std::string Text(const std::vector<NearDuplicates>& groups) {
  std::string text;
  for (const NearDuplicates& group : groups) {
    text += (text.empty() ? "" : "; ") + group.image + ":";
    for (const std::string& other : group.others) text += " " + other;
  }
  return text;
}

// The dataset, each of whose images is followed by copies of its features with
// more noise, as in frames of a board that stands still.
Dataset WithNoisyCopies(const Dataset& dataset, int num_copies) {
  SimulationOptions noise;
  noise.noise_px = 0.05;
  Random random(3);
  Dataset result = {dataset.image_size, {}};
  for (const ImageFeatures& image : dataset.images) {
    result.images.push_back(image);
    for (int k = 0; k < num_copies; ++k) {
      result.images.push_back(image);
      result.images.back().image += "." + std::to_string(k);
      AddNoise(noise, &random, &result.images.back().features);
    }
  }
  return result;
}

TEST(NearDuplicates, MoveLessThanTheDistance) {
  EXPECT_EQ(Text(Find({Lattice("a", 0), Lattice("b", 2.9), Lattice("c", 50)})),
            "a: b");
  EXPECT_EQ(Text(Find({Lattice("a", 0), Lattice("b", 3.1)})), "");
  EXPECT_EQ(Text(Find({Lattice("a", 0), Lattice("b", 0)}, 0)), "");
}

TEST(NearDuplicates, UsuallyMoveLessThanAThousandthOfTheLongerSide) {
  EXPECT_DOUBLE_EQ(DefaultDuplicatePx({6000, 4000}), 6);
  EXPECT_DOUBLE_EQ(DefaultDuplicatePx({120, 160}), 1);
  const auto find = [](double x) {
    return Text(FindNearDuplicates(
        {{kSameViewsSize, {Lattice("a", 0), Lattice("b", x)}}}, {},
        std::nullopt));
  };
  EXPECT_EQ(find(0.9), "a: b");
  EXPECT_EQ(find(1.1), "");
}

// Frames of a slow video: the first and the last one are different views.
TEST(NearDuplicates, DoNotChain) {
  std::vector<ImageFeatures> frames;
  for (int i = 0; i < 9; ++i)
    frames.push_back(Lattice(std::to_string(i), 1.2 * i));
  EXPECT_EQ(Text(Find(frames)), "0: 1 2; 3: 4 5; 6: 7 8");
}

TEST(NearDuplicates, AFewMisreadFeaturesDoNotTellThemApart) {
  ImageFeatures misread = Lattice("b", 0);
  for (int k = 0; k < 4; ++k) misread.features[9 * k].pixel.x() += 100;
  EXPECT_EQ(Text(Find({Lattice("a", 0), misread})), "a: b");
  misread.features[5].pixel.x() += 100;
  EXPECT_EQ(Text(Find({Lattice("a", 0), misread})), "");
}

TEST(NearDuplicates, HaveHalfOfTheFeaturesInCommon) {
  ImageFeatures left = Lattice("left", 0), right = Lattice("right", 0);
  left.features.resize(25);
  right.features.erase(right.features.begin(), right.features.begin() + 15);
  EXPECT_EQ(Text(Find({left, right})), "");
  right.features.erase(right.features.end() - 6, right.features.end());
  EXPECT_EQ(Text(Find({left, right})), "left: right");
}

TEST(NearDuplicates, AreStoodForByTheOneWithMostFeatures) {
  ImageFeatures covered = Lattice("a", 0);
  covered.features.resize(30);
  EXPECT_EQ(Text(Find({covered, Lattice("b", 0), Lattice("c", 0)})), "b: a c");
}

TEST(NearDuplicates, OfImagesHeldOutAreGroupsOfTheirOwn) {
  const std::vector<ImageFeatures> images = {Lattice("a", 0), Lattice("b", 0),
                                             Lattice("c", 0), Lattice("d", 0),
                                             Lattice("e", 50)};
  EXPECT_EQ(Text(Find(images, 3, {"a", "d", "e"})), "a: d; b: c");
  const auto copies = [&](const std::vector<std::string>& held_out) {
    return FindHeldOutDuplicates({{kSameViewsSize, images}}, held_out, 3);
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(copies({"a", "d", "e"}), (Names{"a", "d"}));
  EXPECT_EQ(copies({"a", "b", "c", "d"}), Names{});
  EXPECT_EQ(copies({"e"}), Names{});
}

TEST(NearDuplicates, AnotherBoardThatMovesIsAnotherView) {
  const auto with = [](const std::string& name, double x) {
    return Joined(Lattice(name, 0), Lattice("", x, 7));
  };
  EXPECT_EQ(Text(Find({with("a", 200), with("b", 201)})), "a: b");
  EXPECT_EQ(Text(Find({with("a", 200), with("b", 210)})), "");
  // A board that is not there tells nothing.
  EXPECT_EQ(Text(Find({Lattice("a", 0), with("b", 200)})), "b: a");
}

TEST(NearDuplicates, OfARigAreTheSameInAllCameras) {
  const auto find = [](double left, double right) {
    return Text(FindNearDuplicates(
        {{kSameViewsSize, {Lattice("a", 0), Lattice("b", left)}},
         {kSameViewsSize, {Lattice("b", right), Lattice("a", 0)}}},
        {}, 3));
  };
  EXPECT_EQ(find(1, 1), "a: b");
  EXPECT_EQ(find(1, 10), "");
  EXPECT_EQ(find(10, 1), "");
}

TEST(NearDuplicates, RandomViewsAreDifferent) {
  EXPECT_EQ(Text(FindNearDuplicates({ViewsOf(60)}, {}, std::nullopt)), "");
}

// ---- Calibration -----------------------------------------------------------

CalibrationOptions CoarseCells() {
  CalibrationOptions options;
  options.knot_spacing_px = 160;
  options.num_threads = 2;
  return options;
}

// Each image that was given is used, or in a group.
std::set<std::string> RigCameraImages(const CalibrationResult& result) {
  std::set<std::string> names;
  for (const ImageFeatures& image : result.features.images)
    names.insert(image.image);
  for (const NearDuplicates& group : result.near_duplicates)
    names.insert(group.others.begin(), group.others.end());
  return names;
}

TEST(CalibrateNearDuplicates, CopiesChangeNoFigure) {
  const Dataset ten = ViewsOf(10);
  CalibrationOptions options = CoarseCells();
  options.knot_spacing_px = 0;
  const CalibrationResult alone = Calibrate(ten, TestBoard(), options);
  const CalibrationResult copied =
      Calibrate(WithNoisyCopies(ten, 3), TestBoard(), options);
  EXPECT_EQ(copied.knot_spacing_px, alone.knot_spacing_px);
  EXPECT_EQ(copied.camera.held_out->rms_px, alone.camera.held_out->rms_px);
  EXPECT_EQ(copied.camera.uncertainty->lattice.MedianPx(),
            alone.camera.uncertainty->lattice.MedianPx());
  EXPECT_EQ(copied.features.images.size(), 10u);
  EXPECT_EQ(copied.near_duplicates.size(), 10u);
  EXPECT_EQ(RigCameraImages(copied).size(), 40u);
  EXPECT_TRUE(copied.rejected_images.empty());
  EXPECT_TRUE(std::any_of(
      copied.assessment.reasons.begin(), copied.assessment.reasons.end(),
      [](const std::string& reason) {
        return reason.find("40 images show 10 different views") == 0;
      }));
}

TEST(CalibrateNearDuplicates, AllImagesHavePoses) {
  const Dataset shots = ViewsOf(6, 3);
  const CalibrationResult result = Calibrate(shots, TestBoard(), CoarseCells());
  ASSERT_EQ(result.poses.size(), 18u);
  const auto pose_of = [&](const std::string& image) {
    return std::find_if(
               result.poses.begin(), result.poses.end(),
               [&](const BoardPose& pose) { return pose.image == image; })
        ->camera_from_board;
  };
  for (const NearDuplicates& group : result.near_duplicates)
    for (const std::string& other : group.others)
      EXPECT_LT((pose_of(other).translation - pose_of(group.image).translation)
                    .norm(),
                1e-3);
}

bool HasReasonOf(const CalibrationResult& result, const std::string& words) {
  const auto& reasons = result.assessment.reasons;
  return std::any_of(reasons.begin(), reasons.end(),
                     [&](const std::string& reason) {
                       return reason.find(words) != std::string::npos;
                     });
}

// The partners of an image that is held out keep its view.
TEST(CalibrateNearDuplicates, HoldingOutAnImageLosesNoView) {
  CalibrationOptions options = CoarseCells();
  options.hold_out = {"sim0000.png", "sim0004.png"};
  const CalibrationResult result =
      Calibrate(ViewsOf(6, 3), TestBoard(), options);
  EXPECT_EQ(result.features.images.size(), 6u);
  std::set<std::string> tested;
  for (const FeatureResidual& residual : result.held_out)
    tested.insert(residual.image);
  EXPECT_EQ(tested, std::set<std::string>(options.hold_out.begin(),
                                          options.hold_out.end()));
  for (const FeatureResidual& residual : result.training)
    EXPECT_EQ(tested.count(residual.image), 0u) << residual.image;
  EXPECT_EQ(result.held_out_duplicates, options.hold_out);
  EXPECT_TRUE(HasReasonOf(result,
                          "near-duplicates of training images: 2 images "
                          "(sim0000.png, ...); "));
  EXPECT_TRUE(HasReasonOf(result, "18 images show 6 different views"));
}

TEST(CalibrateNearDuplicates, HoldingOutAllImagesOfAViewLosesIt) {
  CalibrationOptions options = CoarseCells();
  options.hold_out = {"sim0003.png", "sim0004.png", "sim0005.png"};
  const CalibrationResult result =
      Calibrate(ViewsOf(6, 3), TestBoard(), options);
  EXPECT_EQ(result.features.images.size(), 5u);
  EXPECT_TRUE(result.held_out_duplicates.empty());
  EXPECT_FALSE(HasReasonOf(result, "held-out error is too optimistic"));
}

// The verdict then says that they are alike.
TEST(CalibrateNearDuplicates, AreAllUsedWhereTooFewDiffer) {
  const CalibrationResult result =
      Calibrate(ViewsOf(2, 5), TestBoard(), CoarseCells());
  EXPECT_TRUE(result.near_duplicates.empty());
  EXPECT_EQ(result.features.images.size(), 10u);
  EXPECT_EQ(result.assessment.word, "fail");
  EXPECT_NE(
      result.assessment.failure.find("10 images show only 2 different views"),
      std::string::npos);
}

TEST(CalibrateNearDuplicates, AreAllUsedWhereTooFewDifferThatAreNotHeldOut) {
  CalibrationOptions options = CoarseCells();
  for (int i = 0; i < 6; ++i)
    options.hold_out.push_back("sim000" + std::to_string(i) + ".png");
  const CalibrationResult result =
      Calibrate(ViewsOf(4, 3), TestBoard(), options);
  EXPECT_TRUE(result.near_duplicates.empty());
  EXPECT_EQ(result.features.images.size(), 6u);
}

TEST(CalibrateNearDuplicates, AreMeasuredAgainOnce) {
  constexpr double kMovePx = 0.01;
  const Dataset shots = ViewsOf(6, 3);
  size_t num_poses = 0;
  CalibrationInput input = {"", shots};
  input.refine_features = [&](const CameraModel&, const Pattern&,
                              const std::vector<BoardPose>& poses) {
    num_poses = poses.size();
    Dataset again = shots;
    for (ImageFeatures& image : again.images)
      for (Feature& feature : image.features) feature.pixel.x() += kMovePx;
    return again;
  };
  const CalibrationResult result =
      Calibrate({input}, TestBoard(), CoarseCells()).cameras.front();
  EXPECT_EQ(num_poses, 6u);
  EXPECT_NEAR(*result.refinement_rms_px, kMovePx, 1e-9);
  EXPECT_EQ(result.features.images.size(), 6u);
  EXPECT_EQ(RigCameraImages(result).size(), 18u);
}

TEST(CalibrateNearDuplicates, InstantsOfARigCountOnce) {
  SimulationOptions seen;
  seen.num_images = 9;
  seen.features_per_image = 100;
  const auto lens = std::make_shared<OpenCvModel>(ExampleLens());
  const auto calibrate = [&](int num_shots, double duplicate_px) {
    seen.num_shots = num_shots;
    const SimulatedRigObservations views =
        SimulateRig(MakeCameraRow(lens, 2, 0.1), TestBoard(), seen);
    CalibrationOptions options = CoarseCells();
    options.model = "opencv";
    options.duplicate_px = duplicate_px;
    return Calibrate(
        {{"left", views.datasets[0]}, {"right", views.datasets[1]}},
        TestBoard(), options);
  };
  const RigResult shots = calibrate(3, 2);
  EXPECT_EQ(shots.baselines[0].num_shared_views, 9);
  for (const CalibrationResult& camera : shots.cameras) {
    EXPECT_EQ(camera.features.images.size(), 9u);
    EXPECT_EQ(camera.near_duplicates.size(), 9u);
    EXPECT_EQ(camera.poses.size(), 27u);
  }
  // Poses of all images are the rig's.
  for (size_t k = 0; k < shots.cameras[0].poses.size(); ++k) {
    const Pose right_from_left =
        shots.cameras[1].poses[k].camera_from_board *
        shots.cameras[0].poses[k].camera_from_board.Inverse();
    EXPECT_LT(
        (right_from_left.translation - shots.camera_from_rig[1].translation)
            .norm(),
        1e-9);
  }
  EXPECT_EQ(calibrate(3, 0).baselines[0].num_shared_views, 27);
}

}  // namespace
}  // namespace raygrid
