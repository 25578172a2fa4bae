#include "dataset/pattern.h"
#include "support.h"
#include "target/chessboard_sheet.h"

namespace raygrid {
namespace {

ChessboardSheet A4Sheet() {
  return PlanChessboardSheet(9, 6, 25, ParsePage("A4"));
}

TEST(ChessboardSheet, YamlIsThePattern) {
  const Pattern pattern = ParsePattern("sheet", ChessboardYaml(A4Sheet()));
  ASSERT_EQ(pattern.boards.size(), 1u);
  EXPECT_EQ(pattern.boards[0].kind, "chessboard");
  EXPECT_EQ(pattern.boards[0].columns, 9);
  EXPECT_EQ(pattern.boards[0].rows, 6);
  EXPECT_DOUBLE_EQ(pattern.boards[0].square_m, 0.025);
}

TEST(ChessboardSheet, PageIsTurnedOnlyIfNeeded) {
  EXPECT_EQ(A4Sheet().page.width_mm, 297);
  EXPECT_EQ(PlanChessboardSheet(6, 8, 25, ParsePage("A4")).page.width_mm, 210);
}

TEST(ChessboardSheet, TooLargeBoardsAreRefused) {
  for (const double square_mm : {29.5, 100.0, 1e9})
    ExpectError(ExitCode::kUsage, {"does not fit"},
                [&] { PlanChessboardSheet(9, 6, square_mm, ParsePage("A4")); });
}

TEST(ChessboardSheet, ImpossibleBoardsAreRefused) {
  for (const double square_mm : {0.0, -5.0, double{NAN}, double{INFINITY}})
    ExpectError(ExitCode::kUsage, {},
                [&] { PlanChessboardSheet(9, 6, square_mm, ParsePage("A4")); });
  for (const int count : {1, 0, -3, 1001}) {
    ExpectError(ExitCode::kUsage, {},
                [&] { PlanChessboardSheet(count, 6, 1, ParsePage("A4")); });
    ExpectError(ExitCode::kUsage, {},
                [&] { PlanChessboardSheet(9, count, 1, ParsePage("A4")); });
  }
}

TEST(ParsePage, KnowsNamesAndMillimetres) {
  EXPECT_EQ(ParsePage("A3").height_mm, 420);
  EXPECT_EQ(ParsePage("letter").width_mm, 215.9);
  EXPECT_EQ(ParsePage("600x400.5mm").width_mm, 600);
  EXPECT_EQ(ParsePage("600x400.5mm").height_mm, 400.5);
}

TEST(ParsePage, RefusesAnythingElse) {
  for (const char* name :
       {"", "A5", "600x400", "600x400cm", "600mm", "-600x400mm", "0x400mm",
        "nanx400mm", "600xinfmm", "6000x400mm", "600x400mm2", "600x400mx",
        "600x400mmm"})
    ExpectError(ExitCode::kUsage, {"--page"}, [&] { ParsePage(name); });
}

bool StartsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

TEST(ChessboardSheet, PagesAreOfTheirFormat) {
  EXPECT_TRUE(StartsWith(ChessboardPdf(A4Sheet()), "%PDF-"));
  EXPECT_TRUE(StartsWith(ChessboardSvg(A4Sheet()), "<?xml"));
  EXPECT_NE(ChessboardSvg(A4Sheet()).find("width=\"297mm\""),
            std::string::npos);
  EXPECT_TRUE(StartsWith(ChessboardPng(A4Sheet(), 50), "\x89PNG\r\n"));
}

TEST(ChessboardSheet, PagesAreTheSameEachTime) {
  EXPECT_TRUE(ChessboardPdf(A4Sheet()) == ChessboardPdf(A4Sheet()));
  EXPECT_TRUE(ChessboardSvg(A4Sheet()) == ChessboardSvg(A4Sheet()));
  EXPECT_TRUE(ChessboardPng(A4Sheet(), 50) == ChessboardPng(A4Sheet(), 50));
}

TEST(ChessboardSheet, ImpossibleResolutionsAreRefused) {
  for (const double dpi : {0.0, -100.0, 1e6, double{NAN}})
    ExpectError(ExitCode::kUsage, {"--dpi"},
                [&] { ChessboardPng(A4Sheet(), dpi); });
}

}  // namespace
}  // namespace raygrid
