#include "dataset/pattern.h"

#include <yaml-cpp/yaml.h>

#include "support.h"

namespace raygrid {
namespace {

std::string WithBoards(const std::string& boards) {
  return "raygrid_pattern: 1\nboards:\n" + boards;
}

std::string ChessboardYaml(const std::string& columns, const std::string& rows,
                           const std::string& square_m) {
  return WithBoards("  - {id: 0, kind: chessboard, columns: " + columns +
                    ", rows: " + rows + ", square_m: " + square_m + "}\n");
}

void ExpectPatternRefused(const std::string& yaml,
                          std::vector<std::string> words) {
  words.push_back("p.yaml");
  ExpectError(ExitCode::kInvalidInput, words,
              [&] { ParsePattern("p.yaml", yaml); });
}

TEST(Pattern, PointsLieRowByRowOnTheLattice) {
  const Pattern pattern = ChessboardPattern(4, 3, 0.025);
  ASSERT_EQ(pattern.boards.size(), 1u);
  const Board& board = pattern.boards[0];
  ASSERT_EQ(board.points.size(), 12u);
  EXPECT_EQ(board.points[board.PointIndex(2, 1)],
            Eigen::Vector3d(0.05, 0.025, 0));
}

TEST(Pattern, GivenPointsReplaceTheLattice) {
  const Pattern pattern = ParsePattern(
      "p", WithBoards("  - {id: 3, kind: chessboard, columns: 2, rows: 2, "
                      "square_m: 0.1, points: [[0, 0, 0], [0.1, 0, 0.001], "
                      "[0, 0.1, 0], [0.11, 0.1, 0]]}\n"));
  const Board& board = *pattern.FindBoard(3);
  EXPECT_EQ(board.points[1], Eigen::Vector3d(0.1, 0, 0.001));
  EXPECT_EQ(board.NominalPoints()[1], Eigen::Vector3d(0.1, 0, 0));
}

// Two boards, and a body of so many poses.
std::string WithBody(const std::string& boards, int num_poses) {
  std::string yaml =
      WithBoards(
          "  - {id: 3, kind: chessboard, columns: 2, rows: 2, square_m: 0.1}\n"
          "  - {id: 7, kind: chessboard, columns: 2, rows: 2, square_m: "
          "0.1}\n") +
      "board_bodies:\n  - boards: " + boards + "\n    first_from_board:\n";
  for (int i = 0; i < num_poses; ++i)
    yaml += "      - {rotation: {w: 1, x: 0, y: 0, z: 0}, translation: {x: " +
            std::to_string(i) + ", y: 0, z: 0}}\n";
  return yaml;
}

TEST(Pattern, BodiesAreReadAsTheyWereWritten) {
  Pattern pattern = ParsePattern("p", WithBody("[7, 3]", 2));
  ASSERT_EQ(pattern.rigid_targets.size(), 1u);
  EXPECT_EQ(pattern.rigid_targets[0].boards, (std::vector<int>{7, 3}));
  EXPECT_EQ(pattern.rigid_targets[0].first_from_board[1].translation.x(), 1);
  const std::string text = FormatPattern(pattern);
  EXPECT_EQ(FormatPattern(ParsePattern("p", text)), text);
  EXPECT_EQ(ParsePattern("p", text).rigid_targets[0].boards,
            pattern.rigid_targets[0].boards);
  // Another calibration may find none.
  pattern.rigid_targets.clear();
  EXPECT_EQ(FormatPattern(pattern).find("board_bodies"), std::string::npos);
}

TEST(Pattern, RefusesBodiesThatAreNone) {
  ExpectPatternRefused(WithBody("[3, 4]", 2), {"board 4"});
  ExpectPatternRefused(WithBody("[3, 3]", 2), {"board 3 is in two bodies"});
  ExpectPatternRefused(WithBody("[3]", 1), {"requires at least two boards"});
  ExpectPatternRefused(WithBody("[3, 7]", 1), {"2 boards with 1 poses"});
  ExpectPatternRefused(WithBody("all", 2), {});
  ExpectPatternRefused(ChessboardYaml("4", "3", "0.1") + "board_bodies: 3\n",
                       {"'board_bodies' is not a list"});
}

TEST(Pattern, ListsOfPointsAreBoardsOfOneRow) {
  const Pattern pattern =
      ParsePattern("p", WithBoards("  - {id: 0, kind: points, xyz: [[0, 0, 0], "
                                   "[0.1, 0, 0], [0, 0.1, 0.2]]}\n"));
  EXPECT_EQ(pattern.boards[0].columns, 3);
  EXPECT_EQ(pattern.boards[0].rows, 1);
  EXPECT_EQ(pattern.boards[0].NominalPoints()[2], Eigen::Vector3d(0, 0.1, 0.2));
}

TEST(Pattern, ListsOfPointsMayHaveRows) {
  const std::string points =
      "xyz: [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], "
      "[2, 1, 0]]}\n";
  const std::string start = "  - {id: 0, kind: points, columns: ";
  const Pattern pattern =
      ParsePattern("p", WithBoards(start + "3, rows: 2, " + points));
  const Board& board = pattern.boards[0];
  EXPECT_EQ(board.points[board.PointIndex(1, 1)], Eigen::Vector3d(1, 1, 0));
  for (const char* size :
       {"2", "-3, rows: -2", "6, rows: 2", "65536, rows: 65536", "0, rows: 6"})
    ExpectPatternRefused(WithBoards(start + size + ", " + points), {"found 6"});
}

TEST(Pattern, BoardsHaveAHundredThousandPointsInAllAtMost) {
  EXPECT_EQ(ParsePattern("p", ChessboardYaml("1000", "100", "0.01"))
                .boards[0]
                .points.size(),
            100000u);
  ExpectPatternRefused(ChessboardYaml("1000", "1000", "0.01"),
                       {"1000000 feature points"});
  std::string boards;
  for (int id = 0; id < 12; ++id)
    boards += "  - {id: " + std::to_string(id) +
              ", kind: chessboard, columns: 100, rows: 100, square_m: 0.01}\n";
  ExpectPatternRefused(WithBoards(boards),
                       {"board 11", "110000 feature points"});
}

TEST(Pattern, SquaresAreFromAMicrometreToAHundredMetres) {
  for (const char* square_m : {"1e-6", "0.025", "100"})
    EXPECT_EQ(
        ParsePattern("p", ChessboardYaml("4", "3", square_m)).boards.size(),
        1u);
  for (const char* square_m :
       {"1e-300", "9.9e-7", "0", "-0.025", "100.1", "1e300", ".nan", ".inf"})
    ExpectPatternRefused(ChessboardYaml("4", "3", square_m),
                         {"square_m", "metres"});
  for (const char* x : {"1e300", "-1e6", ".inf", ".nan"})
    ExpectPatternRefused(
        WithBoards("  - {id: 0, kind: points, xyz: [[0, 0, 0], "
                   "[0.1, 0, 0], [0, 0.1, " +
                   std::string(x) + "]]}\n"),
        {"metres"});
}

TEST(Pattern, FindsBoardsById) {
  const Pattern pattern = ChessboardPattern(4, 3, 0.025);
  EXPECT_EQ(pattern.FindBoard(0), &pattern.boards[0]);
  EXPECT_EQ(pattern.FindBoard(1), nullptr);
}

TEST(Pattern, MalformedYamlIsRefusedWithItsLine) {
  ExpectPatternRefused("raygrid_pattern: 1\nboards: [{id: 0\nx", {"line"});
  ExpectPatternRefused("a: b: c", {"line 1"});
}

TEST(Pattern, OtherDocumentsAreRefused) {
  ExpectPatternRefused("", {"raygrid_pattern"});
  ExpectPatternRefused("just text", {"raygrid_pattern"});
  ExpectPatternRefused("[1, 2]", {"raygrid_pattern"});
  ExpectPatternRefused("boards: []", {"raygrid_pattern"});
  ExpectPatternRefused("raygrid_pattern: 2\nboards: []", {"version"});
  ExpectPatternRefused("raygrid_pattern: 1\n", {"boards"});
  ExpectPatternRefused("raygrid_pattern: 1\nboards: []", {"boards"});
  ExpectPatternRefused("raygrid_pattern: 1\nboards: [5]", {"board 1"});
}

TEST(Pattern, MissingKeysAreNamed) {
  const std::string keys[5] = {"id: 0", "kind: chessboard", "columns: 4",
                               "rows: 3", "square_m: 0.02"};
  for (const std::string& missing : keys) {
    std::string board = "  -";
    std::string lead = " ";
    for (const std::string& key : keys)
      if (key != missing) {
        board += lead + key + "\n";
        lead = "    ";
      }
    ExpectPatternRefused(
        WithBoards(board),
        {"board 1", "'" + missing.substr(0, missing.find(':')) + "'"});
  }
}

TEST(Pattern, BadSizesAreRefused) {
  for (const char* bad : {"1", "0", "-4", "1001", "4.5", "many", "1e9"}) {
    ExpectPatternRefused(ChessboardYaml(bad, "6", "0.02"), {"columns"});
    ExpectPatternRefused(ChessboardYaml("9", bad, "0.02"), {"rows"});
  }
  for (const char* bad : {"0", "-0.02", ".nan", ".inf", "wide"})
    ExpectPatternRefused(ChessboardYaml("9", "6", bad), {"square_m"});
}

TEST(Pattern, WrongPointsAreRefused) {
  const std::string start =
      "  - {id: 0, kind: chessboard, columns: 2, rows: 2, square_m: 0.1, "
      "points: ";
  for (const char* points : {"[[0, 0, 0]]", "[[0, 0], [0, 0], [0, 0], [0, 0]]",
                             "[[0, 0, .nan], [0, 0, 0], [0, 0, 0], [0, 0, 0]]",
                             "[[a, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]"})
    ExpectPatternRefused(WithBoards(start + points + "}\n"), {});
  ExpectPatternRefused(WithBoards("  - {id: 0, kind: points}\n"), {});
}

TEST(Pattern, BoardsNeedDifferentIds) {
  ExpectPatternRefused(ChessboardYaml("9", "6", "0.02") +
                           "  - {id: 0, kind: chessboard, columns: 4, rows: 3, "
                           "square_m: 0.02}\n",
                       {"board 2", "duplicate"});
}

TEST(Pattern, FormatKeepsUnknownKeysAndPoints) {
  Pattern pattern = ParsePattern(
      "p",
      "raygrid_pattern: 1\nmaker: someone\npage: {width_m: 0.3}\nboards:\n"
      "  - {id: 0, kind: chessboard, columns: 3, rows: 2, square_m: 0.1, "
      "glued_to: aluminium}\n");
  TestRandom random(1);
  for (Eigen::Vector3d& p : pattern.boards[0].points)
    p += 0.001 * random.NormalVector<3>();
  const std::string text = FormatPattern(pattern);
  const YAML::Node root = YAML::Load(text);
  EXPECT_EQ(root["maker"].as<std::string>(), "someone");
  EXPECT_EQ(root["page"]["width_m"].as<double>(), 0.3);
  EXPECT_EQ(root["boards"][0]["glued_to"].as<std::string>(), "aluminium");
  const Pattern read = ParsePattern("again", text);
  for (int i = 0; i < 6; ++i)
    EXPECT_LT((read.boards[0].points[i] - pattern.boards[0].points[i])
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9);
}

}  // namespace
}  // namespace raygrid
