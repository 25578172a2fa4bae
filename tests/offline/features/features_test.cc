#include <opencv2/imgcodecs.hpp>

#include "dataset/files.h"
#include "features/pattern_detector.h"
#include "photographs.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

TEST(PatternDetector, TinyImagesShowNothing) {
  for (const Pattern& pattern : {ChessboardPattern(9, 6, 0.025),
                                 CharucoPattern(7, 5), AprilGridPattern()})
    for (const int side : {1, 2, 3, 7, 20})
      EXPECT_TRUE(
          Detected(ToGrey(cv::Mat(side, side, CV_8U, cv::Scalar(9))), pattern)
              .features.empty());
}

TEST(PatternDetector, BoardsOfAllKindsAreFound) {
  for (const auto& kind : TargetKinds()) {
    if (!kind->is_drawable) continue;
    const Pattern pattern = ParseBoardSpec(kind->specification);
    const Photograph photograph(pattern.boards[0], kFrontal);
    const auto features = Detected(photograph.image(), pattern).features;
    constexpr double kMostOf = 0.8, kDrawingErrorPx = 0.2;
    EXPECT_GT(features.size(), kMostOf * pattern.boards[0].num_points())
        << kind->name;
    EXPECT_LT(photograph.WorstErrorPx(features), kDrawingErrorPx) << kind->name;
  }
}

TEST(PatternDetector, OptionsOutOfRangeAreRefused) {
  for (const int window_px : {0, 3, 20, 103, -21})
    ExpectError(ExitCode::kInvalidInput, {"window", "odd"}, [&] {
      PatternDetector(CharucoPattern(7, 5),
                      {Refinement::kIntensities, window_px});
    });
}

// A folder with photographs and other things of one pattern.
class DetectFeaturesTest : public ::testing::Test {
 protected:
  std::string Add(const std::string& name, const Image& image) {
    WriteFile(folder_ / name, EncodePng(image));
    return folder_ / name;
  }
  std::string AddEmpty(const std::string& name, int width = 640) {
    return Add(name, ToGrey(cv::Mat(480, width, CV_8U, cv::Scalar(128))));
  }
  std::string AddBoard(const std::string& name) {
    return Add(name, Photograph(pattern_.boards[0], kFrontal).image());
  }
  FolderDetection Detect(const std::vector<std::string>& paths) {
    return DetectFeatures(paths, pattern_, {}, nullptr, 2, nullptr);
  }

  TemporaryFolder folder_;
  Pattern pattern_ = ChessboardPattern(9, 6, 0.025);
};

TEST_F(DetectFeaturesTest, GoesThroughAllImagesByName) {
  std::vector<double> done;
  const Dataset dataset =
      DetectFeatures({AddBoard("a.png"), AddEmpty("b.png")}, pattern_, 2,
                     [&](double d) { done.push_back(d); });
  EXPECT_EQ(dataset.image_size, (ImageSize{640, 480}));
  ASSERT_EQ(dataset.images.size(), 2u);
  EXPECT_EQ(dataset.images[0].image, "a.png");
  EXPECT_EQ(dataset.images[0].features.size(), 54u);
  EXPECT_TRUE(dataset.images[1].features.empty());
  EXPECT_EQ(done, (std::vector<double>{0.5, 1}));
}

TEST_F(DetectFeaturesTest, DamagedImagesAreNamedAndSkipped) {
  WriteFile(folder_ / "b.png", "this is no image");
  const FolderDetection found =
      Detect({AddBoard("a.png"), folder_ / "b.png", AddBoard("c.png"),
              folder_ / "nowhere.png"});
  ASSERT_EQ(found.dataset.images.size(), 2u);
  EXPECT_EQ(found.dataset.images[1].image, "c.png");
  EXPECT_EQ(found.paths[1], folder_ / "c.png");
  EXPECT_EQ(found.images[1].features.size(), 54u);
  ASSERT_EQ(found.skipped.size(), 2u);
  EXPECT_EQ(found.skipped[0].path, folder_ / "b.png");
  EXPECT_EQ(found.skipped[0].reason.find("not an image"), 0u);
  EXPECT_EQ(found.skipped[1].path, folder_ / "nowhere.png");
}

TEST_F(DetectFeaturesTest, MostImagesTellTheSize) {
  const FolderDetection found =
      Detect({AddEmpty("a.png", 641), AddEmpty("b.png"), AddEmpty("c.png")});
  EXPECT_EQ(found.dataset.image_size, (ImageSize{640, 480}));
  EXPECT_EQ(found.dataset.images.size(), 2u);
  ASSERT_EQ(found.skipped.size(), 1u);
  EXPECT_EQ(found.skipped[0].path, folder_ / "a.png");
  EXPECT_NE(found.skipped[0].reason.find("641 x 480"), std::string::npos);
}

TEST_F(DetectFeaturesTest, RefusesImagesOfWhichNoSizeIsTheMostFrequent) {
  const std::string a = AddEmpty("a.png"), b = AddEmpty("b.png", 641);
  const std::string c = AddEmpty("c.png"), d = AddEmpty("d.png", 641);
  ExpectError(ExitCode::kInvalidInput, {"b.png", "641 x 480"}, [&] {
    Detect({a, b});
  });
  ExpectError(ExitCode::kInvalidInput, {"b.png", "641 x 480"}, [&] {
    Detect({a, b, c, d});
  });
}

TEST_F(DetectFeaturesTest, RefusesWhatCannotBeDetectedOrRead) {
  ExpectError(ExitCode::kInvalidInput, {"nowhere.png"},
              [&] { Detect({"nowhere.png"}); });
  ExpectError(ExitCode::kInvalidInput, {"nowhere.png", "other 1 image"}, [&] {
    Detect({"nowhere.png", "neither.png"});
  });
  pattern_.boards[0].kind = "circles";
  ExpectError(ExitCode::kInvalidInput, {"circles"}, [&] { Detect({}); });
}

TEST_F(DetectFeaturesTest, RefusesTwoImagesOfOneName) {
  ExpectError(ExitCode::kInvalidInput, {"a.png", "same name"}, [&] {
    Detect({AddEmpty("a.png"), folder_ / "sub/../a.png"});
  });
}

}  // namespace
}  // namespace raygrid
