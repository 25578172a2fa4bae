#include "dataset/dataset.h"

#include <locale.h>

#include "dataset/csv.h"
#include "dataset/files.h"
#include "dataset/repeated_images.h"
#include "support.h"

namespace raygrid {
namespace {

const char kHeader[] = "image,board,column,row,x,y\n";

std::map<std::string, Dataset> ReadFeaturesText(const std::string& text) {
  const TemporaryFolder folder;
  WriteFile(folder / "features.csv", text);
  return ReadFeatures(folder / "features.csv");
}

// The file is named, and what else is expected in the message.
void ExpectFeaturesRefused(const std::string& text,
                           std::vector<std::string> words) {
  words.push_back("features.csv");
  ExpectError(ExitCode::kInvalidInput, words, [&] { ReadFeaturesText(text); });
}

TEST(ReadFeatures, ReadsImagesInTheFilesOrder) {
  const Dataset dataset = ReadFeaturesText(std::string(kHeader) +
                                           "b.png,0,1,2,3.5,4.25\n"
                                           "a.png,0,0,0,1e1,-0.5\n"
                                           "b.png,7,1,3,5,6\n")
                              .at("");
  ASSERT_EQ(dataset.images.size(), 2u);
  EXPECT_EQ(dataset.num_features(), 3u);
  EXPECT_EQ(dataset.images[0].image, "b.png");
  ASSERT_EQ(dataset.images[0].features.size(), 2u);
  const Feature& feature = dataset.images[0].features[0];
  EXPECT_EQ(feature.column, 1);
  EXPECT_EQ(feature.row, 2);
  EXPECT_EQ(feature.pixel, Eigen::Vector2d(3.5, 4.25));
  EXPECT_EQ(dataset.images[0].features[1].board, 7);
  EXPECT_EQ(dataset.images[1].features[0].pixel, Eigen::Vector2d(10, -0.5));
}

TEST(ReadFeatures, AcceptsCommentsExtraColumnsSpacesAndCarriageReturns) {
  const Dataset dataset = ReadFeaturesText(
                              "# found by hand\r\n"
                              "\r\n"
                              "row, column,note,image,x,y,board\r\n"
                              "  2 ,1,blurred,a.png, 3.5 ,4,0\r\n"
                              "# doubtful\r\n"
                              "\r\n"
                              "3,1,,a.png,5,6,0")
                              .at("");
  ASSERT_EQ(dataset.num_features(), 2u);
  EXPECT_EQ(dataset.images[0].features[0].row, 2);
  EXPECT_EQ(dataset.images[0].features[0].pixel, Eigen::Vector2d(3.5, 4));
}

TEST(ReadFeatures, SeparatesCameras) {
  const auto datasets = ReadFeaturesText(
      "camera,image,board,column,row,x,y\n"
      "left,1.png,0,0,0,1,2\n"
      "right,1.png,0,0,0,3,4\n");
  ASSERT_EQ(datasets.size(), 2u);
  EXPECT_EQ(datasets.at("right").images[0].features[0].pixel.x(), 3);
}

TEST(ReadFeatures, RefusesWhatIsNoFiniteNumberNamingTheLine) {
  for (const char* bad :
       {"nan", "NaN", "inf", "-inf", "", "1,5", "1.5px", "0x10", "1e999"}) {
    const std::string text = std::string(kHeader) + "a.png,0,0,0,1,2\n" +
                             "a.png,0,0,1," + bad + ",2\n";
    ExpectFeaturesRefused(text, {"line 3"});
  }
}

TEST(ReadFeatures, RefusesWhatIsNoIntegerNamingTheLineAndColumn) {
  for (const char* bad : {"1.5", "x", "", "99999999999"})
    ExpectFeaturesRefused(std::string(kHeader) + "a.png,0," + bad + ",0,1,2\n",
                          {"line 2", "column"});
}

TEST(ReadFeatures, RefusesMissingColumns) {
  ExpectFeaturesRefused("image,board,column,row,x\na.png,0,0,0,1\n", {"'y'"});
  ExpectFeaturesRefused("", {"'image'"});
}

TEST(ReadFeatures, RefusesLinesWithAnotherNumberOfFields) {
  ExpectFeaturesRefused(std::string(kHeader) + "a.png,0,0,0,1\n", {"line 2"});
  ExpectFeaturesRefused(std::string(kHeader) + "\na.png,0,0,0,1,2,3\n",
                        {"line 3"});
}

TEST(ReadFeatures, TakesNamesAsTheyAre) {
  const Dataset dataset = ReadFeaturesText(std::string(kHeader) +
                                           "#1.png,0,9,9,1,2\n"  // a comment
                                           "\"#1.png\",0,0,0,1,2\r\n"
                                           "a#1.png,0,0,0,1,2\n"
                                           " \"a,b.png\" ,0,0,0,1,2\n"
                                           "\"a \"\"b\"\".png\",0,0,0,1,2\n"
                                           "\"a\nb.png\",0,0,0,1,2\n"
                                           "\" a.png\",0,0,0,1,2\n")
                              .at("");
  std::vector<std::string> names;
  for (const ImageFeatures& image : dataset.images)
    names.push_back(image.image);
  EXPECT_EQ(names,
            (std::vector<std::string>{"#1.png", "a#1.png", "a,b.png",
                                      "a \"b\".png", "a\nb.png", " a.png"}));
}

TEST(ReadFeatures, RefusesQuotesOutOfPlaceNamingTheLine) {
  const std::string start = std::string(kHeader) + "\"a\nb\",0,0,0,1,2\n";
  ExpectFeaturesRefused(start + "\"a,0,0,0,1,2\n",
                        {"line 4", "unterminated quote"});
  ExpectFeaturesRefused(start + "a\"b,0,0,0,1,2\n", {"line 4", "quote"});
  ExpectFeaturesRefused(start + "\"a\"b,0,0,0,1,2\n", {"line 4", "quote"});
  ExpectFeaturesRefused(start + "a,b,0,0,0,1,2\n", {"line 4", "quote names"});
  ExpectFeaturesRefused(start + "a\xe9,0,0,0,1,2\n", {"line 4", "UTF-8"});
}

TEST(ReadFeatures, RefusesByteOrderMarksAndColumnsTwice) {
  ExpectFeaturesRefused(std::string("\xef\xbb\xbf") + kHeader + "a,0,0,0,1,2\n",
                        {"byte order mark"});
  ExpectFeaturesRefused("image,board,column,row,x,y,x\na,0,0,0,1,2,3\n",
                        {"duplicate column 'x'"});
}

TEST(ReadFeatures, RefusesFeaturesStatedTwice) {
  ExpectFeaturesRefused(std::string(kHeader) +
                            "a.png,0,3,4,1,2\n"
                            "b.png,0,3,4,1,2\n"
                            "a.png,0,3,4,1.5,2\n",
                        {"line 4"});
}

TEST(ReadFeatures, RefusesFilesWithoutFeatures) {
  ExpectFeaturesRefused(kHeader, {"no features"});
  ExpectError(ExitCode::kInvalidInput, {"nowhere.csv"},
              [] { ReadFeatures("nowhere.csv"); });
}

TEST(ReadFeatures, InvertsFormatFeatures) {
  Dataset dataset;
  TestRandom random(1);
  const std::vector<std::string> names = {
      "z.png",   "#1.jpg", "a,b.png", "say \"a\".png",  "a\nb.png",
      " a.png ", "a\r",    "\"",      "caf\xc3\xa9.png"};
  for (const std::string& image : names) {
    dataset.images.push_back({image, {}});
    for (int i = 0; i < 50; ++i)
      dataset.images.back().features.push_back(
          {i % 3, i, 2 * i, random.PixelIn({0, 0, 640, 480})});
  }
  const Dataset read = ReadFeaturesText(FormatFeatures(dataset)).at("");
  ASSERT_EQ(read.images.size(), names.size());
  for (size_t k = 0; k < names.size(); ++k) {
    EXPECT_EQ(read.images[k].image, dataset.images[k].image);
    ASSERT_EQ(read.images[k].features.size(), 50u);
    for (int i = 0; i < 50; ++i)
      EXPECT_LT((read.images[k].features[i].pixel -
                 dataset.images[k].features[i].pixel)
                    .cwiseAbs()
                    .maxCoeff(),
                5.1e-6);
  }
}

TEST(ReadFeatures, InvertsFormatFeaturesOfARig) {
  std::vector<NamedDataset> cameras;
  for (const char* camera : {"left", "right"})
    cameras.push_back(
        {camera,
         {{640, 480}, {{"1", {{0, 2, 3, {cameras.size() + 4.5, 6}}}}}}});
  const auto read = ReadFeaturesText(FormatFeatures(cameras));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read.at("left").images[0].features[0].pixel.x(), 4.5);
  EXPECT_EQ(read.at("right").images[0].features[0].pixel.x(), 5.5);
  EXPECT_EQ(read.at("right").images[0].image, "1");
}

Dataset ImagesNamed(const std::vector<std::string>& names) {
  Dataset dataset;
  for (const std::string& name : names) dataset.images.push_back({name, {}});
  return dataset;
}

TEST(RenameImagesByNumber, TakesTheLastNumber) {
  Dataset dataset =
      ImagesNamed({"left01.jpg", "cam2_000120.png", "0.5.png", "l000.png",
                   "1403636579763555584.png", "7", "a3b.tar.png"});
  RenameImagesByNumber("camera left", &dataset);
  std::vector<std::string> names;
  for (const ImageFeatures& image : dataset.images)
    names.push_back(image.image);
  EXPECT_EQ(names, (std::vector<std::string>{"1", "120", "5", "0",
                                             "1403636579763555584", "7", "3"}));
}

TEST(RenameImagesByNumber, RefusesNamesThatTellNoInstant) {
  Dataset none = ImagesNamed({"a1.png", "left.jpg2"});
  ExpectError(ExitCode::kInvalidInput, {"camera left", "left.jpg2"},
              [&] { RenameImagesByNumber("camera left", &none); });
  Dataset twice = ImagesNamed({"1_left2.png", "3_left02.png"});
  ExpectError(ExitCode::kInvalidInput, {"1_left2.png", "3_left02.png"},
              [&] { RenameImagesByNumber("camera left", &twice); });
}

// A locale with decimal commas for the time of a test.
class CommaLocale {
 public:
  CommaLocale() : is_set_(false) {
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR"})
      is_set_ = is_set_ || setlocale(LC_ALL, name);
  }
  ~CommaLocale() { setlocale(LC_ALL, "C"); }
  bool is_set() const { return is_set_; }

 private:
  bool is_set_;
};

TEST(ReadFeatures, DoesNotDependOnTheLocale) {
  const CommaLocale locale;
  if (!locale.is_set())
    GTEST_SKIP() << "no locale with decimal commas is installed (de_DE.UTF-8 "
                    "or the like)";
  const Dataset dataset =
      ReadFeaturesText(std::string(kHeader) + "a.png,0,0,0,1.5,2.25\n").at("");
  EXPECT_EQ(dataset.images[0].features[0].pixel, Eigen::Vector2d(1.5, 2.25));
  EXPECT_NE(FormatFeatures(dataset).find("1.50000,2.25000"), std::string::npos);
}

Dataset OneFeature(const Feature& feature) {
  return {{640, 480}, {{"a.png", {feature}}}};
}

TEST(RequireConsistent, AcceptsFeaturesOfThePatternInTheImage) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.02);
  EXPECT_NO_THROW(
      RequireConsistent("f", OneFeature({0, 8, 5, {-0.5, 479.4}}), pattern));
}

TEST(RequireConsistent, RefusesForeignFeatures) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.02);
  for (const Feature& feature :
       {Feature{1, 0, 0, {1, 1}}, Feature{0, 9, 0, {1, 1}},
        Feature{0, 0, 6, {1, 1}}, Feature{0, -1, 0, {1, 1}},
        Feature{0, 0, 0, {640, 1}}, Feature{0, 0, 0, {1, -0.6}}})
    ExpectError(ExitCode::kInvalidInput, {"f.csv", "a.png"}, [&] {
      RequireConsistent("f.csv", OneFeature(feature), pattern);
    });
}

TEST(FormatPoses, KeepsNames) {
  const TemporaryFolder folder;
  const std::string name = "#1, \"left\"\n.png";
  WriteFile(folder / "poses.csv",
            FormatPoses({{"left", {{name, 4, {}}}}, {"right", {}}}));
  const auto poses = ReadPoses(folder / "poses.csv");
  EXPECT_EQ(poses.at("left").at(0).image, name);
}

TEST(FormatPoses, WritesUnitQuaternionsWithPositiveRealPart) {
  const Pose pose = {Eigen::Quaterniond(-0.5, 0.5, -0.5, 0.5), {1, 2, 3}};
  const std::string name = "poses", text = FormatPoses({{"a.png", 4, pose}});
  CsvReader table(name, text,
                  {"image", "board", "qw", "qx", "qy", "qz", "tx", "ty", "tz"});
  ASSERT_TRUE(table.Next());
  EXPECT_EQ(table.Integer("board"), 4);
  EXPECT_EQ(table.Number("qw"), 0.5);
  EXPECT_EQ(table.Number("qx"), -0.5);
  EXPECT_EQ(table.Number("tz"), 3);
  EXPECT_FALSE(table.Next());
}

// Images of a lattice, each moved by another distance.
Dataset LatticeImages(const std::string& name, double x_px, int num_images) {
  Dataset dataset;
  for (int i = 0; i < num_images; ++i) {
    dataset.images.push_back({name + std::to_string(i), {}});
    for (int k = 0; k < 12; ++k)
      dataset.images.back().features.push_back(
          {0, k % 4, k / 4, {x_px + 10 * i + 20 * (k % 4), 20.0 * (k / 4)}});
  }
  return dataset;
}

TEST(FindSharedImage, IsACopyOfAnyNameOrMostImagesSavedAgain) {
  const Dataset images = LatticeImages("a", 0, 5);
  // A copy of one image, under another name and in the midst of others.
  Dataset others = LatticeImages("b", 3, 5);
  EXPECT_FALSE(FindSharedImage(images, others));
  others.images[3].features = images.images[1].features;
  const auto pair = FindSharedImage(images, others);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->first, "a1");
  EXPECT_EQ(pair->second, "b3");
  // Images of one name, which were compressed again or are seen from apart.
  EXPECT_TRUE(FindSharedImage(images, LatticeImages("a", 0.02, 5)));
  EXPECT_FALSE(FindSharedImage(images, LatticeImages("a", 0.2, 5)));
  EXPECT_FALSE(FindSharedImage(images, LatticeImages("b", 0.02, 5)));
  EXPECT_FALSE(FindSharedImage({}, {}));
  EXPECT_FALSE(FindSharedImage({{}, {{"a", {}}}}, {{}, {{"a", {}}}}));
}

}  // namespace
}  // namespace raygrid
