#include "features/star_detection.h"

#include <Eigen/LU>
#include <algorithm>
#include <cstdio>
#include <map>
#include <utility>

#include "features/feature_detection.h"
#include "features/tag_detection.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {640, 480};
constexpr double kNoise = 2;  // grey levels
constexpr int kThreads = 1;
constexpr double kSquare = 0.012;

std::string BoardYaml(int id, int columns, int rows, int segments, int tag,
                      int tag_column, int tag_row) {
  const auto text = [](int number) { return std::to_string(number); };
  return "  - {id: " + text(id) + ", kind: star, columns: " + text(columns) +
         ", rows: " + text(rows) +
         ", square_m: 0.012, segments: " + text(segments) +
         ", tags: [{family: tag36h11, id: " + text(tag) +
         ", column: " + text(tag_column) + ", row: " + text(tag_row) +
         ", squares: 4}]}\n";
}

Pattern PatternOf(const std::string& boards) {
  return ParsePattern("pattern", "raygrid_pattern: 1\nboards:\n" + boards);
}

Pattern StarPattern(int segments = 16, int tag = 0) {
  return PatternOf(BoardYaml(0, 16, 15, segments, tag, 6, 5));
}

Pattern TwoBoards() {
  return PatternOf(BoardYaml(0, 10, 12, 16, 0, 3, 4) +
                   BoardYaml(1, 10, 12, 16, 1, 3, 4));
}

ImagingOptions NoisyImaging(uint64_t seed) {
  ImagingOptions options;  // black 30, white 220, blur 0.7
  options.read_noise = kNoise;
  options.seed = seed;
  return options;
}

GreyImage WithoutNoise(const RenderedImage& exact) {
  GreyImage image;
  image.size = exact.size;
  image.levels = exact.levels;
  for (const float level : exact.levels)
    image.bytes.push_back(static_cast<uint8_t>(std::lround(level)));
  return image;
}

GreyImage WithNoise(const RenderedImage& exact, uint64_t seed) {
  return MakeGreyImage(AddNoiseAndQuantize(exact, NoisyImaging(seed)));
}

struct Shot {
  Pose pose;
  RenderedImage exact;
};

// A lens and a board in front of it.
struct Scene {
  std::unique_ptr<CameraModel> camera;
  Board board;
  std::vector<Shot> shots;

  std::vector<Feature> Truth(const Shot& shot) const {
    return VisibleFeatures(*camera, board, shot.pose);
  }
};

// Without a tag nothing is found.
bool ShowsTag(const CameraModel& camera, const Board& board, const Pose& pose) {
  const BoardTag& tag = board.tags[0];
  for (const int u : {0, tag.squares}) {
    for (const int v : {0, tag.squares}) {
      const auto corner =
          camera.Project(pose * Eigen::Vector3d((tag.column + u) * kSquare,
                                                (tag.row + v) * kSquare, 0));
      if (!corner || !WholeImage(kSize).Contains(*corner)) return false;
    }
  }
  return true;
}

// Poses in which the tag is wholly seen.
std::vector<Pose> ChoosePoses(const CameraModel& camera, const Board& board,
                              double min_square_px, int count, uint64_t seed) {
  PoseOptions options;
  options.min_square_px = min_square_px;
  std::vector<Pose> chosen;
  for (const Pose& pose : RandomPoses(camera, board.points.back() / 2, kSquare,
                                      6 * count, options, seed))
    if (static_cast<int>(chosen.size()) < count &&
        ShowsTag(camera, board, pose))
      chosen.push_back(pose);
  return chosen;
}

Scene MakeScene(const std::string& lens, const Pattern& pattern,
                double min_square_px, int num_images, uint64_t seed) {
  Scene scene;
  scene.camera = SimulatedLens(lens, kSize);
  scene.board = pattern.boards[0];
  const PixelRays rays(*scene.camera, kThreads);
  const BoardSurface surface(scene.board);
  for (const Pose& pose :
       ChoosePoses(*scene.camera, scene.board, min_square_px, num_images, seed))
    scene.shots.push_back({pose, RenderImage(rays, {{&surface, pose}},
                                             ImagingOptions(), kThreads)});
  return scene;
}

// The three lenses, made when first asked for.
const Scene& SceneOf(const std::string& lens) {
  static std::map<std::string, Scene> scenes;
  const auto found = scenes.find(lens);
  if (found != scenes.end()) return found->second;
  constexpr int kNumImages = 6;
  return scenes[lens] = MakeScene(lens, StarPattern(), 16, kNumImages, 5);
}

// Differences from the truth, by axis.
struct Errors {
  Eigen::Array2d sum = {0, 0}, sum_of_squares = {0, 0};
  int count = 0;
  double largest = 0;
  int num_visible = 0, num_visible_found = 0;

  Eigen::Array2d Mean() const { return sum / std::max(1, count); }
  Eigen::Array2d Rms() const {
    return (sum_of_squares / std::max(1, count)).sqrt();
  }
  double FoundFraction() const {
    return num_visible_found / std::max<double>(1, num_visible);
  }
};

void Add(const Eigen::Vector2d& error, Errors* errors) {
  errors->sum += error.array();
  errors->sum_of_squares += error.array().square();
  errors->largest = std::max(errors->largest, error.norm());
  ++errors->count;
}

void Print(const std::string& name, const Errors& errors) {
  std::printf(
      "%s: %d features, RMS %.5f %.5f, mean %.5f %.5f, largest %.4f px; found "
      "%d of %d (%.2f %%)\n",
      name.c_str(), errors.count, errors.Rms().x(), errors.Rms().y(),
      errors.Mean().x(), errors.Mean().y(), errors.largest,
      errors.num_visible_found, errors.num_visible,
      100 * errors.FoundFraction());
}

// Whether a star's square is seen, more than 12 px wide.
bool IsWhollyVisible(const CameraModel& camera, const Pose& pose, int column,
                     int row) {
  const auto project = [&](double u, double v) {
    return camera.Project(
        pose * Eigen::Vector3d((column + u) * kSquare, (row + v) * kSquare, 0));
  };
  const Area pixels = WholeImage(kSize);
  for (const double u : {-0.5, 0.5}) {
    for (const double v : {-0.5, 0.5}) {
      const auto corner = project(u, v);
      if (!corner || !pixels.Contains(*corner)) return false;
    }
  }
  constexpr double kMinWidth = 12;
  const double width = (*project(0.5, 0) - *project(-0.5, 0)).norm();
  const double height = (*project(0, 0.5) - *project(0, -0.5)).norm();
  return std::min(width, height) > kMinWidth;
}

using FeatureKey = std::pair<int, int>;

void Compare(const Scene& scene, const Shot& shot,
             const std::vector<Feature>& found, Errors* errors) {
  std::map<FeatureKey, Eigen::Vector2d> truth;
  for (const Feature& feature : scene.Truth(shot))
    truth[{feature.row, feature.column}] = feature.pixel;
  std::map<FeatureKey, int> has;
  for (const Feature& feature : found) {
    const FeatureKey key(feature.row, feature.column);
    ++has[key];
    ASSERT_EQ(truth.count(key), 1u) << feature.pixel.transpose();
    Add(feature.pixel - truth[key], errors);
  }
  for (const auto& [key, pixel] : truth) {
    if (!IsWhollyVisible(*scene.camera, shot.pose, key.second, key.first))
      continue;
    ++errors->num_visible;
    errors->num_visible_found += has.count(key);
  }
}

Errors Measure(const Scene& scene, const StarDetector& detector, bool noisy) {
  Errors errors;
  uint64_t seed = 100;
  for (const Shot& shot : scene.shots) {
    const GreyImage image =
        noisy ? WithNoise(shot.exact, seed++) : WithoutNoise(shot.exact);
    Compare(scene, shot, detector.Detect(image).features, &errors);
  }
  return errors;
}

Errors MeasureNoisy(const std::string& lens) {
  const Errors errors =
      Measure(SceneOf(lens), StarDetector(StarPattern(), {}), true);
  Print(lens + ", noise 2", errors);
  return errors;
}

constexpr int kReach = 10;  // half of the window

// The least covariance that the window's grey levels allow, or a little more:
// central differences flatten edges as sharp as these, so that an estimate can
// be better than this by a fifth.
Eigen::Matrix2d CramerRaoBound(const RenderedImage& image, int column,
                               int row) {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (int y = row - kReach; y <= row + kReach; ++y) {
    for (int x = column - kReach; x <= column + kReach; ++x) {
      const Eigen::Vector2d gradient(
          (image.at(x + 1, y) - image.at(x - 1, y)) / 2.0,
          (image.at(x, y + 1) - image.at(x, y - 1)) / 2.0);
      information += gradient * gradient.transpose();
    }
  }
  return kNoise * kNoise * information.inverse();
}

// Over all features whose window is in the image.
double RmsOfBound(const Scene& scene) {
  double sum = 0;
  int count = 0;
  for (const Shot& shot : scene.shots) {
    for (const Feature& feature : scene.Truth(shot)) {
      if (!WholeImage(kSize).Contains(feature.pixel, -(kReach + 2))) continue;
      const int column = static_cast<int>(std::lround(feature.pixel.x()));
      const int row = static_cast<int>(std::lround(feature.pixel.y()));
      sum += CramerRaoBound(shot.exact, column, row).trace() / 2;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(StarDetector, IsNearTheBoundOfNoise) {
  const Errors errors = MeasureNoisy("pinhole");
  const double bound = RmsOfBound(SceneOf("pinhole"));
  const double rms = errors.Rms().maxCoeff();
  std::printf("RMS %.5f px, Cramer-Rao bound %.5f px: %.3f times\n", rms, bound,
              rms / bound);
  RecordProperty("rms_px", std::to_string(rms));
  RecordProperty("bound_px", std::to_string(bound));
  EXPECT_GT(errors.count, 500);
  EXPECT_LE(rms, 1.5 * bound);
}

TEST(StarDetector, IsExactWithoutNoise) {
  const Errors errors =
      Measure(SceneOf("pinhole"), StarDetector(StarPattern(), {}), false);
  Print("pinhole, no noise", errors);
  EXPECT_GT(errors.count, 500);
  EXPECT_LE(errors.Rms().maxCoeff(), 0.004);
  EXPECT_LE(errors.Mean().abs().maxCoeff(), 0.001);
}

TEST(StarDetector, IsAccurateWithAWideLens) {
  EXPECT_LE(MeasureNoisy("wide").Rms().maxCoeff(), 0.008);
}

TEST(StarDetector, IsAccurateWithAFisheye) {
  EXPECT_LE(MeasureNoisy("fisheye").Rms().maxCoeff(), 0.011);
}

TEST(StarDetector, FindsNearlyAllAndNothingElse) {
  int num_visible = 0, num_found = 0;
  for (const std::string lens : {"pinhole", "wide", "fisheye"}) {
    const Errors errors = MeasureNoisy(lens);
    EXPECT_LE(errors.largest, 0.5) << lens;
    num_visible += errors.num_visible;
    num_found += errors.num_visible_found;
  }
  EXPECT_GT(num_visible, 1500);
  EXPECT_GE(num_found, 0.99 * num_visible);
}

TEST(StarDetector, FindsNearlyAllAtTheEdgeOf190Degrees) {
  const Scene scene = MakeScene("fisheye190", StarPattern(), 16, 3, 8);
  const Errors errors = Measure(scene, StarDetector(StarPattern(), {}), true);
  Print("fisheye190", errors);
  EXPECT_GT(errors.num_visible, 200);
  EXPECT_GE(errors.FoundFraction(), 0.98);
  EXPECT_LE(errors.largest, 0.5);
  EXPECT_LE(errors.Rms().maxCoeff(), 0.03);
}

TEST(StarDetector, FindsStarsOfAnyNumberOfSegments) {
  for (const int segments : {4, 6, 8, 12, 16, 20, 24, 28, 32}) {
    const Pattern pattern = StarPattern(segments);
    const Scene scene = MakeScene("pinhole", pattern, 24, 1, 9);
    const Errors errors = Measure(scene, StarDetector(pattern, {}), true);
    Print(std::to_string(segments) + " segments", errors);
    EXPECT_GT(errors.count, 50) << segments;
    EXPECT_GE(errors.FoundFraction(), 0.95) << segments;
    EXPECT_LT(errors.Rms().maxCoeff(), 0.02) << segments;
  }
}

Errors MeasureRefinement(Refinement refinement, const std::string& name) {
  DetectionOptions options;
  options.refinement = refinement;
  const Errors errors =
      Measure(SceneOf("pinhole"), StarDetector(StarPattern(), options), false);
  Print(name, errors);
  return errors;
}

TEST(StarDetector, RefinesBySymmetryOfThreeImages) {
  const std::pair<Refinement, std::string> refinements[] = {
      {Refinement::kIntensities, "intensities"},
      {Refinement::kGradientsXY, "gradients"},
      {Refinement::kGradientMagnitude, "gradient magnitude"}};
  for (const auto& [refinement, name] : refinements) {
    const Errors errors = MeasureRefinement(refinement, name);
    EXPECT_GT(errors.count, 500) << name;
    EXPECT_LT(errors.Rms().maxCoeff(), 0.02) << name;
  }
}

TEST(StarDetector, RefinesOtherwiseOrNotAtAll) {
  EXPECT_GT(MeasureRefinement(Refinement::kCornerSubpix, "cornerSubPix").count,
            500);
  EXPECT_GT(MeasureRefinement(Refinement::kNone, "none").count, 500);
}

// Upright, the first feature at a place in the image.
Pose UprightAt(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  constexpr double kDistance = 0.25;
  const Eigen::Vector3d ray = camera.Unproject(pixel).value();
  Pose pose;
  pose.translation = ray * (kDistance / ray.z());
  return pose;
}

TEST(StarDetector, FindsTwoBoardsInAnImage) {
  const auto camera = SimulatedLens("pinhole", kSize);
  const Pattern pattern = TwoBoards();
  const BoardSurface left(pattern.boards[0]), right(pattern.boards[1]);
  const RenderedImage exact =
      RenderImage(PixelRays(*camera, kThreads),
                  {{&left, UprightAt(*camera, {50, 80})},
                   {&right, UprightAt(*camera, {360, 100})}},
                  ImagingOptions(), kThreads);
  const ImageDetection detection =
      StarDetector(pattern, {}).Detect(WithNoise(exact, 1));
  std::map<int, int> counts;
  for (const Feature& feature : detection.features) ++counts[feature.board];
  EXPECT_EQ(counts[0], 10 * 12 - 5 * 5);
  EXPECT_EQ(counts[1], 10 * 12 - 5 * 5);
  EXPECT_TRUE(detection.remarks.empty());
}

const Pose& Upright() {
  static const Pose pose =
      UprightAt(*SimulatedLens("pinhole", kSize), {140, 70});
  return pose;
}

// All its stars lie in the image.
RenderedImage ExactUprightImage(const ImagingOptions& imaging) {
  static const auto camera = SimulatedLens("pinhole", kSize);
  static const PixelRays rays(*camera, kThreads);
  static const BoardSurface surface(StarPattern().boards[0]);
  return RenderImage(rays, {{&surface, Upright()}}, imaging, kThreads);
}

GreyImage UprightImage() {
  return WithNoise(ExactUprightImage(ImagingOptions()), 1);
}

// Differences from the truth in the upright image.
Errors MeasureUpright(const std::string& name, const GreyImage& image) {
  Scene scene;
  scene.camera = SimulatedLens("pinhole", kSize);
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
  ImagingOptions imaging;
  imaging.blur_px = 2.5;
  const Errors errors = MeasureUpright("blur 2.5 px", imaging);
  EXPECT_GE(errors.FoundFraction(), 0.99);
  EXPECT_LE(errors.largest, 0.2);
}

TEST(StarDetector, FindsStarsInOverexposure) {
  ImagingOptions imaging;
  imaging.exposure = 1.8;  // paper would be at 396 of 255
  const Errors errors = MeasureUpright("exposure 1.8", imaging);
  EXPECT_GE(errors.FoundFraction(), 0.99);
  EXPECT_LE(errors.largest, 0.1);
}

TEST(StarDetector, FindsStarsInUnderexposure) {
  ImagingOptions imaging;
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
  const Image grey =
      AddNoiseAndQuantize(ExactUprightImage(ImagingOptions()), {});
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
  const auto camera = SimulatedLens("pinhole", kLargeSize);
  const BoardSurface near(pattern.boards[0]), far(pattern.boards[1]);
  Pose near_pose = UprightAt(*camera, {60, 60});
  near_pose.translation *= 1.3;
  Pose far_pose = UprightAt(*camera, {700, 200});
  far_pose.translation *= 4.4;
  return WithNoise(RenderImage(PixelRays(*camera, kThreads),
                               {{&near, near_pose}, {&far, far_pose}},
                               ImagingOptions(), kThreads),
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
  const GreyImage image = UprightImage();
  const StarDetector detector(StarPattern(), {});
  EXPECT_FALSE(detector.Detect(image).features.empty());
  const ImageDetection detection = detector.Detect(Mirrored(image));
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.remarks.size(), 1u);
  EXPECT_NE(detection.remarks[0].find("mirrored"), std::string::npos)
      << detection.remarks[0];
}

TEST(StarDetector, RemarksOnTagsOfNoBoard) {
  const ImageDetection detection =
      StarDetector(StarPattern(16, 5), {}).Detect(UprightImage());
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.remarks.size(), 1u);
  EXPECT_NE(detection.remarks[0].find("tag 0"), std::string::npos)
      << detection.remarks[0];
}

TEST(StarDetector, FindsNothingInAnEmptyImage) {
  const auto camera = SimulatedLens("pinhole", kSize);
  const RenderedImage exact =
      RenderImage(PixelRays(*camera, kThreads), {}, ImagingOptions(), kThreads);
  const ImageDetection detection =
      StarDetector(StarPattern(), {}).Detect(WithNoise(exact, 1));
  EXPECT_TRUE(detection.features.empty());
  EXPECT_TRUE(detection.rejected.empty());
  EXPECT_TRUE(detection.remarks.empty());
}

TEST(StarDetector, FindsTheSameTwice) {
  const GreyImage image = UprightImage();
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
  const auto camera = SimulatedLens("pinhole", kSize);
  const Pattern pattern = TwoBoards();
  const BoardSurface left(pattern.boards[0]), right(pattern.boards[1]);
  return WithNoise(RenderImage(PixelRays(*camera, kThreads),
                               {{&left, UprightAt(*camera, {50, 80})},
                                {&right, UprightAt(*camera, {545, 100})}},
                               ImagingOptions(), kThreads),
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
  const auto camera = SimulatedLens("pinhole", kSize);
  const PixelRays rays(*camera, kThreads);
  // The tag spans 144 to 240 px from the board's first feature: of its ten
  // columns of cells the image shows six.
  Pose pose = UprightAt(*camera, {0, 60});
  pose.translation.x() -= 7.5 * kSquare;
  for (const int segments : {4, 6, 8, 16}) {
    const Pattern pattern = StarPattern(segments);
    const BoardSurface surface(pattern.boards[0]);
    const GreyImage image = WithNoise(
        RenderImage(rays, {{&surface, pose}}, ImagingOptions(), kThreads), 1);
    ASSERT_TRUE(DetectTags(image, TagSearch::kThorough).empty());
    EXPECT_GT(StarDetector(pattern, {}).Detect(image).features.size(), 80u)
        << segments << " segments";
    const ImageDetection other =
        StarDetector(StarPattern(segments, 5), {}).Detect(image);
    EXPECT_TRUE(other.features.empty()) << segments << " segments";
    ASSERT_EQ(other.remarks.size(), 1u);
    EXPECT_NE(other.remarks[0].find("not enough of a tag"), std::string::npos)
        << other.remarks[0];
  }
}

}  // namespace
}  // namespace raygrid
