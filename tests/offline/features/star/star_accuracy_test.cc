// How exact detected stars are, and how many are missed.
#include <Eigen/LU>

#include "star_scenes.h"

namespace raygrid {
namespace {

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
  const Scene scene =
      MakeScene("fisheye190", StarPattern(), 16, 3, 8, FewSamples());
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
    const Scene scene = MakeScene("pinhole", pattern, 24, 1, 9, FewSamples());
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

}  // namespace
}  // namespace raygrid
