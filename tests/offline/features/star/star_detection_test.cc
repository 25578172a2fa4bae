#include "features/star/star_detection.h"

#include "features/board_view/tag_detection.h"
#include "star_scenes.h"

namespace raygrid {
namespace {

// Upright, the first feature at a place in the image.
Pose UprightAt(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  constexpr double kDistance = 0.25;
  const Eigen::Vector3d ray = camera.Unproject(pixel).value();
  Pose pose;
  pose.translation = ray * (kDistance / ray.z());
  return pose;
}

TEST(StarDetector, FindsTwoBoardsInAnImage) {
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const Pattern pattern = TwoBoards();
  const BoardSurface left(pattern.boards[0]), right(pattern.boards[1]);
  const RenderedImage exact =
      RenderImage(PixelRays(*camera, kThreads),
                  {{&left, UprightAt(*camera, {50, 80})},
                   {&right, UprightAt(*camera, {360, 100})}},
                  FewSamples(), kThreads);
  const ImageDetection detection =
      StarDetector(pattern, {}).Detect(WithNoise(exact, 1));
  std::map<int, int> counts;
  for (const Feature& feature : detection.features) ++counts[feature.board];
  EXPECT_EQ(counts[0], 10 * 12 - 5 * 5);
  EXPECT_EQ(counts[1], 10 * 12 - 5 * 5);
  EXPECT_TRUE(detection.warnings.empty());
}

const Pose& Upright() {
  static const Pose pose =
      UprightAt(*MakeSimulatedCamera("pinhole", kSize), {140, 70});
  return pose;
}

// All its stars lie in the image.
RenderedImage ExactUprightImage(const ImagingOptions& imaging) {
  static const auto camera = MakeSimulatedCamera("pinhole", kSize);
  static const PixelRays rays(*camera, kThreads);
  static const BoardSurface surface(StarPattern().boards[0]);
  return RenderImage(rays, {{&surface, Upright()}}, imaging, kThreads);
}

const GreyImage& UprightImage() {
  static const GreyImage image = WithNoise(ExactUprightImage(FewSamples()), 1);
  return image;
}

// Differences from the truth in the upright image.
Errors MeasureUpright(const std::string& name, const GreyImage& image) {
  Scene scene;
  scene.camera = MakeSimulatedCamera("pinhole", kSize);
  scene.board = StarPattern().boards[0];
  Errors errors;
  Compare(scene, {Upright(), {}},
          StarDetector(StarPattern(), {}).Detect(image).features, &errors);
  Print(name, errors);
  return errors;
}

Errors MeasureUpright(const std::string& name, ImagingOptions imaging) {
  imaging.read_noise = kNoise;
  imaging.seed = 1;
  return MeasureUpright(name, MakeGreyImage(AddNoiseAndQuantize(
                                  ExactUprightImage(imaging), imaging)));
}

TEST(StarDetector, FindsStarsInHeavyBlur) {
  ImagingOptions imaging = FewSamples();
  imaging.blur_px = 2.5;
  const Errors errors = MeasureUpright("blur 2.5 px", imaging);
  EXPECT_GE(errors.FoundFraction(), 0.99);
  EXPECT_LE(errors.largest, 0.2);
}

TEST(StarDetector, FindsStarsInOverexposure) {
  ImagingOptions imaging = FewSamples();
  imaging.exposure = 1.8;  // paper would be at 396 of 255
  const Errors errors = MeasureUpright("exposure 1.8", imaging);
  EXPECT_GE(errors.FoundFraction(), 0.99);
  EXPECT_LE(errors.largest, 0.1);
}

TEST(StarDetector, FindsStarsInUnderexposure) {
  ImagingOptions imaging = FewSamples();
  imaging.exposure = 0.1;  // paper at 22, ink at 3, noise of 2
  const Errors errors = MeasureUpright("exposure 0.1", imaging);
  EXPECT_GE(errors.FoundFraction(), 0.99);
  EXPECT_LE(errors.largest, 0.3);
}

TEST(StarDetector, IsMoreExactIn16BitsThanIn8) {
  ImagingOptions imaging;
  imaging.exposure = 0.1;
  const RenderedImage exact = ExactUprightImage(imaging);
  const Errors fine = MeasureUpright(
      "16 bits", MakeGreyImage(DecodeGreyLevels(
                     "image", EncodePng(AddNoiseAndQuantize16(exact, {})))));
  const Errors coarse = MeasureUpright(
      "8 bits", MakeGreyImage(AddNoiseAndQuantize(exact, ImagingOptions())));
  EXPECT_EQ(fine.FoundFraction(), 1);
  EXPECT_LT(fine.Rms().maxCoeff(), coarse.Rms().maxCoeff());
}

TEST(StarDetector, FindsStarsInColourImages) {
  const Image grey = AddNoiseAndQuantize(ExactUprightImage(FewSamples()), {});
  Image yellow = grey;  // no light in the first channel
  yellow.channels = 3;
  yellow.pixels.clear();
  for (const uint8_t level : grey.pixels)
    yellow.pixels.insert(yellow.pixels.end(), {0, level, level});
  const Errors errors = MeasureUpright("yellow", MakeGreyImage(yellow));
  EXPECT_EQ(errors.FoundFraction(), 1);
  EXPECT_LE(errors.largest, 0.03);
}

// A large image of two boards, the second far away.
GreyImage NearAndFarBoard(const Pattern& pattern) {
  constexpr ImageSize kLargeSize = {1000, 600};
  const auto camera = MakeSimulatedCamera("pinhole", kLargeSize);
  const BoardSurface near(pattern.boards[0]), far(pattern.boards[1]);
  Pose near_pose = UprightAt(*camera, {60, 60});
  near_pose.translation *= 1.3;
  Pose far_pose = UprightAt(*camera, {700, 200});
  far_pose.translation *= 4.4;
  return WithNoise(RenderImage(PixelRays(*camera, kThreads),
                               {{&near, near_pose}, {&far, far_pose}},
                               FewSamples(), kThreads),
                   1);
}

TEST(StarDetector, FindsABoardWhoseTagIsMissedAtHalfResolution) {
  const std::string large_tag = "squares: 4", small_tag = "squares: 2";
  std::string far_board = BoardYaml(1, 10, 12, 8, 1, 3, 4);
  far_board.replace(far_board.find(large_tag), large_tag.size(), small_tag);
  const Pattern pattern =
      PatternOf(BoardYaml(0, 10, 12, 8, 0, 3, 4) + far_board);
  const GreyImage image = NearAndFarBoard(pattern);
  ASSERT_EQ(DetectTags(image, TagSearch::kQuick).size(), 1u);
  ASSERT_EQ(DetectTags(image, TagSearch::kThorough).size(), 2u);
  std::map<int, int> counts;
  for (const Feature& f : StarDetector(pattern, {}).Detect(image).features)
    ++counts[f.board];
  EXPECT_EQ(counts[0], 10 * 12 - 5 * 5);
  EXPECT_EQ(counts[1], 10 * 12 - 3 * 3);
}

TEST(StarDetector, RemarksThatAnImageIsMirrored) {
  const GreyImage& image = UprightImage();
  const StarDetector detector(StarPattern(), {});
  EXPECT_FALSE(detector.Detect(image).features.empty());
  const ImageDetection detection = detector.Detect(MirrorImage(image));
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.warnings.size(), 1u);
  EXPECT_NE(detection.warnings[0].find("mirrored"), std::string::npos)
      << detection.warnings[0];
}

TEST(StarDetector, RemarksOnTagsOfNoBoard) {
  const ImageDetection detection =
      StarDetector(StarPattern(16, 5), {}).Detect(UprightImage());
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.warnings.size(), 1u);
  EXPECT_NE(detection.warnings[0].find("tag 0"), std::string::npos)
      << detection.warnings[0];
}

TEST(StarDetector, FindsNothingInAnEmptyImage) {
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const RenderedImage exact =
      RenderImage(PixelRays(*camera, kThreads), {}, FewSamples(), kThreads);
  const ImageDetection detection =
      StarDetector(StarPattern(), {}).Detect(WithNoise(exact, 1));
  EXPECT_TRUE(detection.features.empty());
  EXPECT_TRUE(detection.rejected.empty());
  EXPECT_TRUE(detection.warnings.empty());
}

TEST(StarDetector, FindsTheSameTwice) {
  const GreyImage& image = UprightImage();
  const std::vector<Feature> first =
      StarDetector(StarPattern(), {}).Detect(image).features;
  const std::vector<Feature> second =
      StarDetector(StarPattern(), {}).Detect(image).features;
  ASSERT_FALSE(first.empty());
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].column, second[i].column);
    EXPECT_EQ(first[i].row, second[i].row);
    EXPECT_EQ(first[i].pixel, second[i].pixel);
  }
}

// Board 0, and the left end of board 1 with the first two of ten columns of its
// tag's cells: none of its code.
GreyImage BoardBesideAnEnd() {
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const Pattern pattern = TwoBoards();
  const BoardSurface left(pattern.boards[0]), right(pattern.boards[1]);
  return WithNoise(RenderImage(PixelRays(*camera, kThreads),
                               {{&left, UprightAt(*camera, {50, 80})},
                                {&right, UprightAt(*camera, {545, 100})}},
                               FewSamples(), kThreads),
                   1);
}

TEST(StarDetector, NamesTheOnlyBoardLeftByItsLayout) {
  std::map<int, int> counts;
  for (const Feature& f :
       StarDetector(TwoBoards(), {}).Detect(BoardBesideAnEnd()).features) {
    ++counts[f.board];
    EXPECT_LE(f.column, f.board == 0 ? 9 : 3);
  }
  EXPECT_EQ(counts[0], 10 * 12 - 5 * 5);
  EXPECT_EQ(counts[1], 4 * 12 - 5);
}

TEST(StarDetector, NamesNoneOfSeveralBoardsThatAreLeft) {
  const Pattern three = PatternOf(BoardYaml(0, 10, 12, 16, 0, 3, 4) +
                                  BoardYaml(1, 10, 12, 16, 1, 3, 4) +
                                  BoardYaml(2, 10, 12, 16, 2, 3, 4));
  const Pattern without_the_other =
      PatternOf(BoardYaml(1, 10, 12, 16, 1, 3, 4));
  const GreyImage image = BoardBesideAnEnd();
  for (const Feature& f : StarDetector(three, {}).Detect(image).features)
    EXPECT_EQ(f.board, 0);
  EXPECT_TRUE(
      StarDetector(without_the_other, {}).Detect(image).features.empty());
}

TEST(StarDetector, FindsStarsOfABoardWhoseTagIsCutOff) {
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const PixelRays rays(*camera, kThreads);
  // The tag spans 144 to 240 px from the board's first feature: of its ten
  // columns of cells the image shows six.
  Pose pose = UprightAt(*camera, {0, 60});
  pose.translation.x() -= 7.5 * kSquare;
  for (const int segments : {4, 6, 8, 16}) {
    const Pattern pattern = StarPattern(segments);
    const BoardSurface surface(pattern.boards[0]);
    const GreyImage image = WithNoise(
        RenderImage(rays, {{&surface, pose}}, FewSamples(), kThreads), 1);
    ASSERT_TRUE(DetectTags(image, TagSearch::kThorough).empty());
    EXPECT_GT(StarDetector(pattern, {}).Detect(image).features.size(), 80u)
        << segments << " segments";
    const ImageDetection other =
        StarDetector(StarPattern(segments, 5), {}).Detect(image);
    EXPECT_TRUE(other.features.empty()) << segments << " segments";
    ASSERT_EQ(other.warnings.size(), 1u);
    EXPECT_NE(other.warnings[0].find("no tag to identify"), std::string::npos)
        << other.warnings[0];
  }
}

// A board so near that its squares are this wide where star (4, 4) is seen,
// turned about its columns.
struct NearBoard {
  std::string lens = "pinhole";
  double square_px = 0, tilt_deg = 0;
  Eigen::Vector2d pixel = {14, 30};
  ImageSize size = kSize;
  int tag_squares = 2;
};

Pose PoseOf(const NearBoard& near, const CameraModel& camera) {
  constexpr double kAside = 0.01;
  const double focal_px = (camera.Project({kAside, 0, 1}).value() -
                           camera.Project({0, 0, 1}).value())
                              .x() /
                          kAside;
  const Eigen::Vector3d ray = camera.Unproject(near.pixel).value();
  Pose pose;
  pose.rotation =
      Eigen::AngleAxisd(near.tilt_deg * M_PI / 180, Eigen::Vector3d::UnitY());
  pose.translation = ray * (focal_px * kSquare / near.square_px / ray.z()) -
                     pose.rotation * Eigen::Vector3d(4, 4, 0) * kSquare;
  return pose;
}

// Errors of all stars whose window lies in the image.
Errors MeasureNear(const NearBoard& near) {
  std::string board = BoardYaml(0, 16, 15, 16, 0, 6, 5);
  const std::string large_tag = "squares: 4";
  board.replace(board.find(large_tag), large_tag.size(),
                "squares: " + std::to_string(near.tag_squares));
  const Pattern pattern = PatternOf(board);
  const BoardSurface surface(pattern.boards[0]);
  const auto camera = MakeSimulatedCamera(near.lens, near.size);
  const Pose pose = PoseOf(near, *camera);
  const GreyImage image =
      WithNoise(RenderImage(PixelRays(*camera, kThreads), {{&surface, pose}},
                            FewSamples(), kThreads),
                1);
  std::map<FeatureKey, Eigen::Vector2d> found;
  for (const Feature& f : StarDetector(pattern, {}).Detect(image).features)
    found[{f.row, f.column}] = f.pixel;
  constexpr double kWindowPx = 11.5;
  Errors errors;
  size_t num_seen = 0;
  for (const Feature& f : VisibleFeatures(*camera, pattern.boards[0], pose)) {
    const auto place = found.find({f.row, f.column});
    const bool is_found = place != found.end();
    num_seen += is_found;
    if (!WholeImage(near.size).Contains(f.pixel, -kWindowPx)) continue;
    if (is_found) Add(place->second - f.pixel, &errors);
    ++errors.num_visible;
    errors.num_visible_found += is_found;
    if (!is_found)
      std::printf("missed (%d, %d) at %.1f, %.1f\n", f.column, f.row,
                  f.pixel.x(), f.pixel.y());
  }
  EXPECT_EQ(num_seen, found.size());
  Print(near.lens, errors);
  return errors;
}

TEST(StarDetector, FindsStarsWhoseSquaresTheImagesEdgeCuts) {
  for (const double square_px : {60, 90, 120}) {
    const Errors errors = MeasureNear({"pinhole", square_px});
    EXPECT_GT(errors.num_visible, 12) << square_px;
    EXPECT_EQ(errors.num_visible_found, errors.num_visible) << square_px;
    EXPECT_LE(errors.largest, 0.1) << square_px;
  }
}

// Half of the tag: squares of 60 px, within which there is much that looks like
// stars.
TEST(StarDetector, FindsLargeStarsOfABoardWhoseTagIsCutOff) {
  const auto camera = MakeSimulatedCamera("pinhole", {1280, 800});
  const PixelRays rays(*camera, kThreads);
  const Pattern pattern = PatternOf(BoardYaml(0, 16, 15, 16, 0, 6, 5));
  const BoardSurface surface(pattern.boards[0]);
  Pose pose = PoseOf({"pinhole", 60, 20, {100, 200}}, *camera);
  pose.translation.x() -= 4.5 * kSquare;
  const GreyImage image = WithNoise(
      RenderImage(rays, {{&surface, pose}}, FewSamples(), kThreads), 1);
  ASSERT_TRUE(DetectTags(image, TagSearch::kThorough).empty());
  EXPECT_GT(StarDetector(pattern, {}).Detect(image).features.size(), 60u);
}

TEST(StarDetector, FindsLargeStarsThatALensHasMovedFar) {
  const Errors errors = MeasureNear({"wide", 80, 0, {150, 60}});
  EXPECT_GT(errors.num_visible, 12);
  EXPECT_EQ(errors.num_visible_found, errors.num_visible);
  EXPECT_LE(errors.largest, 0.1);
}

// Neither a homography nor the stars around follow a tag that is bent over much
// of the image; the lens that explains the stars does.
TEST(StarDetector, NamesBoardsOfBentTags) {
  for (const auto& [lens, square_px, x, y] :
       {std::tuple("fisheye", 140, 100, 150),
        std::tuple("fisheye190", 100, 350, 400)}) {
    const Errors errors =
        MeasureNear({lens, double(square_px), 0, {x, y}, {1000, 800}, 4});
    EXPECT_GE(errors.FoundFraction(), 0.95) << lens;
    EXPECT_LE(errors.largest, 0.2) << lens;
  }
}

// The tag lies between them and all others.
TEST(StarDetector, FindsStarsBehindATagAtTheImagesEdge) {
  const Errors errors =
      MeasureNear({"fisheye", 140, 0, {600, 400}, {1000, 800}, 4});
  EXPECT_GE(errors.FoundFraction(), 0.85);
  EXPECT_LE(errors.largest, 0.2);
}

TEST(StarDetector, FindsLargeStarsInStrongPerspective) {
  for (const double tilt_deg : {-50, -30, 30}) {
    const Errors errors = MeasureNear({"pinhole", 70, tilt_deg, {60, 60}});
    EXPECT_GT(errors.num_visible, 12) << tilt_deg;
    EXPECT_EQ(errors.num_visible_found, errors.num_visible) << tilt_deg;
    EXPECT_LE(errors.largest, 0.1) << tilt_deg;
  }
}

}  // namespace
}  // namespace raygrid
