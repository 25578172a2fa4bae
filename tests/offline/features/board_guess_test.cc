// Photographs of other boards than the pattern says.

#include "features/board_guess.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "boards_to_print.h"
#include "dataset/files.h"
#include "support.h"
#include "target/board_sheet.h"
#include "target/board_yaml.h"

namespace raygrid {
namespace {

Pattern PatternOf(const Board& board) {
  return ParsePattern("the pattern", MakeBoardsYaml({board}));
}

// Printed pages, seen from the front.
class BoardGuess : public testing::Test {
 protected:
  void Photograph(const Board& board, bool is_mirrored = false,
                  bool is_negative = false) {
    const BoardSheets sheets = PlanBoardSheets({board}, ParsePage("A4"));
    const std::string png = RenderSheetPng(sheets, board, 100);
    const std::vector<char> bytes(png.begin(), png.end());
    cv::Mat image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    if (is_mirrored) cv::flip(image, image, 1);
    if (is_negative) image = 255 - image;
    for (const char* name : {"a.png", "b.png"}) {
      paths_.push_back(folder_ / name);
      cv::imwrite(paths_.back(), image);
    }
  }

  // The guess that is told the user, or nothing.
  std::string GuessFor(const Board& asked) {
    const Pattern pattern = PatternOf(asked);
    const FolderDetection found =
        DetectFeatures(paths_, pattern, {}, nullptr, 2, nullptr);
    num_features_ = static_cast<int>(found.dataset.num_features());
    return SuggestOtherBoard(found, pattern, "p.yaml", 2).value_or("");
  }

  TemporaryFolder folder_;
  std::vector<std::string> paths_;
  int num_features_ = 0;
};

TEST_F(BoardGuess, FindsOtherSizesOfChessboards) {
  Photograph(Chessboard(9, 6, 25));
  EXPECT_EQ(GuessFor(Chessboard(10, 7, 25)),
            "the images show 9 x 6 inner corners (2 of 2 inspected images), "
            "not 10 x 7 inner corners; correct columns and rows in p.yaml");
  EXPECT_NE(GuessFor(Chessboard(8, 6, 25)).find("show 9 x 6 inner"),
            std::string::npos);
  EXPECT_NE(GuessFor(Chessboard(5, 8, 25)).find("show 6 x 9 inner"),
            std::string::npos);
}

TEST_F(BoardGuess, SaysNothingOfTheBoardAskedFor) {
  Photograph(Chessboard(9, 6, 25));
  EXPECT_EQ(GuessFor(Chessboard(9, 6, 20)), "");
  EXPECT_EQ(GuessFor(Chessboard(6, 9, 20)), "");
  EXPECT_EQ(num_features_, 108);
}

TEST_F(BoardGuess, FindsOtherDictionariesAndSizesOfCharucoBoards) {
  Photograph(Charuco(8, 5, 28));
  Board asked = Charuco(8, 5, 28);
  EXPECT_EQ(GuessFor(asked), "");
  asked.dictionary = "DICT_5X5_100";
  EXPECT_EQ(GuessFor(asked),
            "the images show 8 x 5 inner corners with markers of DICT_4X4_50 "
            "(2 of 2 inspected images), not 8 x 5 inner corners with markers "
            "of DICT_5X5_100; correct the dictionary in p.yaml");
  for (const int columns : {7, 9})
    EXPECT_NE(GuessFor(Charuco(columns, 5, 28)).find("show 8 x 5 inner"),
              std::string::npos);
  EXPECT_NE(GuessFor(Chessboard(8, 5, 28)).find("correct the target kind"),
            std::string::npos);
}

TEST_F(BoardGuess, FindsMirroredCharucoBoards) {
  Photograph(Charuco(8, 5, 28), true);
  EXPECT_EQ(GuessFor(Charuco(8, 5, 28)),
            "the images show a mirrored board of 8 x 5 inner corners with "
            "markers of DICT_4X4_50 (2 of 2 inspected images), not 8 x 5 inner "
            "corners with markers of DICT_4X4_50; mirror the images, or print "
            "the board unmirrored");
  EXPECT_EQ(num_features_, 0);
}

TEST_F(BoardGuess, FindsOtherSizesOfAprilGrids) {
  Photograph(AprilGrid(6, 5, 24));
  EXPECT_EQ(GuessFor(AprilGrid(6, 5, 24)), "");
  EXPECT_NE(GuessFor(AprilGrid(5, 6, 24)).find("an AprilGrid of 6 x 5 tags"),
            std::string::npos);
}

TEST_F(BoardGuess, FindsOtherFamiliesOfTags) {
  Board other = AprilGrid(5, 4, 24);
  other.tag_family = "tag25h9";
  Photograph(other);
  EXPECT_EQ(GuessFor(AprilGrid(5, 4, 24)),
            "the images show an AprilGrid of 5 x 4 tags of tag25h9 (2 of 2 "
            "inspected images), not an AprilGrid of 5 x 4 tags of tag36h11; "
            "correct the tag family in p.yaml");
  EXPECT_EQ(GuessFor(other), "");
  EXPECT_EQ(num_features_, 160);
}

TEST_F(BoardGuess, FindsTagsWithoutCornerSquares) {
  Photograph(PlainTagGrid(5, 4, 24));
  const std::string word =
      "an AprilGrid of 5 x 4 tags of tag36h11 without corner squares (2 of 2 "
      "inspected images)";
  const std::string remedy =
      "; use --pattern aprilgrid:5x4:LENGTH:no-squares:family=tag36h11, where "
      "LENGTH is the side of a tag";
  for (const Board& asked :
       {AprilGrid(5, 4, 24), Chessboard(9, 7, 24), PlainTagGrid(4, 5, 24)}) {
    const std::string guess = GuessFor(asked);
    EXPECT_NE(guess.find(word), std::string::npos) << guess;
    EXPECT_NE(guess.find(remedy), std::string::npos) << guess;
  }
  EXPECT_EQ(GuessFor(PlainTagGrid(5, 4, 20)), "");
  EXPECT_EQ(num_features_, 160);
}

TEST_F(BoardGuess, FindsGridsOfArucoMarkersAndTheirNumbering) {
  Board other = PlainTagGrid(5, 4, 24);
  other.tag_family = "DICT_5X5_100";
  other.is_numbered_from_top = false;
  Photograph(other);
  const std::string guess = GuessFor(Chessboard(9, 7, 24));
  EXPECT_NE(guess.find("aprilgrid:5x4:LENGTH:no-squares:family=DICT_5X5_50:"
                       "numbered-from=bottom,"),
            std::string::npos)
      << guess;
  EXPECT_EQ(GuessFor(other), "");
}

TEST_F(BoardGuess, FindsCharucoBoardsInWhiteOnBlack) {
  Photograph(Charuco(8, 5, 28));
  for (const std::string& path : paths_) {
    cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
    cv::imwrite(path, 255 - image);
  }
  EXPECT_NE(
      GuessFor(Charuco(8, 5, 28))
          .find("an inverted (white on black) board of 8 x 5 inner corners"),
      std::string::npos);
}

TEST(DescribeExpectedBoards, SaysWhatIsReadOfEachKind) {
  const auto sought = [](const Board& board) {
    return DescribeExpectedBoards(PatternOf(board), "p.yaml");
  };
  EXPECT_EQ(sought(Chessboard(9, 6, 25)),
            "searched for a chessboard of 9 x 6 inner corners; check that the "
            "images are sharp and evenly lit, and that p.yaml describes their "
            "target");
  EXPECT_NE(sought(AprilGrid(6, 5, 24))
                .find("6 x 5 tags of tag36h11, with a border of two cells and "
                      "black squares at their corners"),
            std::string::npos);
  EXPECT_NE(sought(Charuco(8, 5, 28)).find("DICT_4X4_50, black on white"),
            std::string::npos);
}

TEST_F(BoardGuess, FindsStarBoardsInWhiteOnBlack) {
  const Board board = StarBoards(Stars(16, 12, 11)).front();
  Photograph(board, false, true);
  const std::string guess = GuessFor(board);
  EXPECT_NE(guess.find("appears in inverted colours (2 of 2 inspected images"),
            std::string::npos)
      << guess;
  EXPECT_NE(guess.find("print the board in black on white"), std::string::npos);
}

}  // namespace
}  // namespace raygrid
