#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "appearance/board_appearance.h"
#include "boards_to_print.h"
#include "dataset/files.h"
#include "dataset/kinds/star.h"
#include "dataset/pattern.h"
#include "features/pattern_detector.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "support.h"
#include "target/board_on_screen.h"
#include "target/board_sheet.h"
#include "target/board_spec.h"
#include "target/marker_boards.h"

namespace raygrid {
namespace {

BoardSheets ChessboardSheet(int columns, int rows, double square_mm) {
  return PlanBoardSheets({Chessboard(columns, rows, square_mm)},
                         ParsePage("A4"));
}

BoardSheets A4Sheet() { return ChessboardSheet(9, 6, 25); }

TEST(BoardSheets, ChessboardsYamlIsThePattern) {
  const std::string yaml = MakeSheetsYaml(A4Sheet());
  EXPECT_NE(yaml.find("  - {id: 0, kind: chessboard, columns: 9, rows: 6, "
                      "square_m: 0.025}\n"),
            std::string::npos)
      << yaml;
  EXPECT_EQ(ParsePattern("sheet", yaml).boards[0].num_points(), 54);
}

TEST(BoardSheets, YamlKeepsAllThatABoardIs) {
  StarBoardOptions stars = Stars(12, 9, 9.3);
  stars.segments = 10;
  stars.num_tags = 2;
  stars.tag_id = 20;
  stars.num_boards = 3;
  stars.tag_squares = 3;
  const BoardSheets sheets = PlanBoardSheets(StarBoards(stars), {200, 200});
  const Pattern pattern = ParsePattern("sheet", MakeSheetsYaml(sheets));
  ASSERT_EQ(pattern.boards.size(), 3u);
  for (int b = 0; b < 3; ++b) {
    const Board& board = pattern.boards[b];
    EXPECT_EQ(board.id, b);
    EXPECT_EQ(board.segments, 10);
    EXPECT_NEAR(board.square_m, 0.0093, 1e-12);
    ASSERT_EQ(board.tags.size(), 2u);
    for (int k = 0; k < 2; ++k) {
      EXPECT_EQ(board.tags[k].id, 20 + 2 * b + k);
      EXPECT_EQ(board.tags[k].column, sheets.boards[b].tags[k].column);
      EXPECT_EQ(board.tags[k].row, sheets.boards[b].tags[k].row);
      EXPECT_EQ(board.tags[k].squares, 3);
    }
  }
}

TEST(BoardSheets, YamlKeepsMarkers) {
  Board charuco = Charuco(8, 5, 20);
  charuco.is_legacy = true;
  charuco.first_marker = 3;
  Board board =
      ParsePattern("c", MakeSheetsYaml(PlanBoardSheets({charuco}, {300, 300})))
          .boards[0];
  EXPECT_NEAR(board.marker_m, 0.015, 1e-12);
  EXPECT_EQ(board.dictionary, "DICT_4X4_50");
  EXPECT_TRUE(board.is_legacy);
  EXPECT_EQ(board.first_marker, 3);
  board = ParsePattern("a", MakeSheetsYaml(PlanBoardSheets(
                                {AprilGrid(6, 5, 24)}, {300, 300})))
              .boards[0];
  EXPECT_EQ(board.columns, 12);
  EXPECT_EQ(board.spacing_ratio, 0.3);
  EXPECT_EQ(board.tag_family, "tag36h11");
}

TEST(BoardSheets, YamlKeepsBoardsOfAllKinds) {
  for (const auto& kind : TargetKinds()) {
    if (!kind->is_drawable) continue;
    const Pattern pattern = ParseBoardSpec(kind->specification);
    EXPECT_EQ(pattern.boards[0].kind, kind->name);
    const std::string yaml = MakeSheetsYaml(
        PlanBoardSheets(pattern.boards, ParsePage("5000x5000mm")));
    EXPECT_EQ(MakeBoardsYaml(ParsePattern("sheet", yaml).boards),
              MakeBoardsYaml(pattern.boards));
  }
}

TEST(BoardSheets, MeasuredPrintsHaveTheirOwnLattice) {
  const BoardSheets sheets =
      PlanBoardSheets({Charuco(6, 4, 20)}, ParsePage("A4"));
  ASSERT_EQ(sheets.ruler_mm, 200);
  Board board =
      ParsePattern("m",
                   MakeSheetsYaml(sheets, ComputePrintScale(sheets, 198, 199)))
          .boards[0];
  EXPECT_NEAR(board.square_m, 0.01985, 1e-9);
  EXPECT_NEAR(board.marker_m, 0.75 * 0.01985, 1e-9);
  EXPECT_LT((board.points[board.PointIndex(5, 3)] -
             Eigen::Vector3d(5 * 0.0198, 3 * 0.0199, 0))
                .norm(),
            1e-8);
  const std::string uniform =
      MakeSheetsYaml(sheets, ComputePrintScale(sheets, 198, 198));
  EXPECT_EQ(uniform.find("points"), std::string::npos);
  EXPECT_NEAR(ParsePattern("m", uniform).boards[0].square_m, 0.0198, 1e-12);
}

TEST(BoardSheets, RulersInOtherUnitsAreRefused) {
  for (const double length : {-200.0, 0.0, 20.0, 0.2, 401.0, double{NAN}}) {
    ExpectError(ExitCode::kUsage, {"150 mm", "--measured"},
                [&] { ComputePrintScale(A4Sheet(), length, 150); });
    ExpectError(ExitCode::kUsage, {"150 mm", "--measured"},
                [&] { ComputePrintScale(A4Sheet(), 150, length); });
  }
}

TEST(BoardSheets, PageIsTurnedOnlyIfNeeded) {
  EXPECT_EQ(A4Sheet().page.width_mm, 297);
  EXPECT_EQ(ChessboardSheet(6, 8, 25).page.width_mm, 210);
}

TEST(BoardSheets, TooLargeBoardsAreRefused) {
  for (const double square_mm : {29.5, 100.0, 1e5})
    ExpectError(ExitCode::kUsage, {"does not fit", "--square-mm 27.2"},
                [&] { ChessboardSheet(9, 6, square_mm); });
  EXPECT_EQ(ChessboardSheet(9, 6, 27.2).page.width_mm, 297);
  ExpectError(ExitCode::kUsage, {"16 x 22 features", "--square-mm 11.5"}, [&] {
    PlanBoardSheets(StarBoards(Stars(16, 23, 12)), {220, 297});
  });
  ExpectError(ExitCode::kUsage, {"--tag-mm", "tags"},
              [&] { PlanBoardSheets({AprilGrid(6, 6, 88)}, ParsePage("A4")); });
  ExpectError(ExitCode::kUsage, {"larger --page"}, [&] {
    PlanBoardSheets({Chessboard(2, 2, 1)}, {9, 9});
  });
}

TEST(BoardSheets, ImpossibleBoardsAreRefused) {
  for (const double square_mm : {0.0, -5.0, double{NAN}, double{INFINITY}})
    ExpectError(ExitCode::kUsage, {},
                [&] { ChessboardSheet(9, 6, square_mm); });
  for (const int count : {1, 0, -3, 1001}) {
    ExpectError(ExitCode::kUsage, {}, [&] { ChessboardSheet(count, 6, 1); });
    ExpectError(ExitCode::kUsage, {}, [&] { ChessboardSheet(9, count, 1); });
  }
  Board board = Charuco(9, 6, 20);
  board.dictionary = "DICT_3X3";
  ExpectError(ExitCode::kUsage, {"DICT_3X3"},
              [&] { PlanBoardSheets({board}, ParsePage("A4")); });
  StarBoardOptions stars = Stars(9, 6, 10);
  stars.tag_id = 587;
  ExpectError(ExitCode::kUsage, {"586"},
              [&] { PlanBoardSheets(StarBoards(stars), ParsePage("A4")); });
}

TEST(StarBoards, AuthorsPatternIsTheDefault) {
  const std::vector<Board> boards = StarBoards(Stars(16, 23, 11.4));
  ASSERT_EQ(boards.size(), 1u);
  EXPECT_EQ(boards[0].segments, 16);
  ASSERT_EQ(boards[0].tags.size(), 1u);
  EXPECT_EQ(boards[0].tags[0].column, 5);
  EXPECT_EQ(boards[0].tags[0].row, 9);
  EXPECT_EQ(boards[0].tags[0].squares, 4);
}

TEST(StarBoards, TagsAreReadableAndLeaveFeatures) {
  EXPECT_EQ(DefaultTagSquares(40, 40, 5), 8);
  EXPECT_EQ(DefaultTagSquares(16, 23, 15), 3);
  EXPECT_EQ(DefaultTagSquares(16, 23, 60), 2);
  EXPECT_EQ(DefaultTagSquares(9, 9, 1e-9), 4);
}

TEST(StarBoards, TagsStandApart) {
  for (const int num_tags : {2, 3, 4, 5, 6, 9}) {
    StarBoardOptions options = Stars(30, 24, 10);
    options.num_tags = num_tags;
    const Board board = StarBoards(options)[0];
    ASSERT_EQ(board.tags.size(), static_cast<size_t>(num_tags));
    for (int i = 0; i < num_tags; ++i)
      for (int j = 0; j < i; ++j) {
        const BoardTag &a = board.tags[i], &b = board.tags[j];
        EXPECT_GT(
            std::max(std::abs(a.column - b.column), std::abs(a.row - b.row)),
            a.squares);
      }
  }
}

TEST(MarkerBoards, EachHasMarkersOfItsOwn) {
  for (Board first : {Charuco(6, 4, 20), AprilGrid(4, 3, 24)}) {
    first.first_marker = 2;
    std::set<int> ids;
    size_t num_markers = 0;
    int id = 0;
    for (const Board& board : MarkerBoards(first, 2)) {
      EXPECT_EQ(board.id, id++);
      const BoardAppearance appearance(board);
      for (const PlacedMarker& marker : appearance.markers()) {
        ids.insert(marker.id);
        ++num_markers;
      }
    }
    EXPECT_EQ(id, 2);
    EXPECT_EQ(ids.size(), num_markers);
    EXPECT_EQ(*ids.begin(), 2);
    EXPECT_EQ(*ids.rbegin(), 1 + static_cast<int>(num_markers));
  }
}

TEST(MarkerBoards, TooFewMarkersAreRefused) {
  ExpectError(ExitCode::kUsage, {"--dictionary", "--boards", "0 to 49"},
              [] { MarkerBoards(Charuco(6, 4, 20), 3); });
  ExpectError(ExitCode::kUsage, {"--boards", "0 to 586"},
              [] { MarkerBoards(AprilGrid(10, 10, 20), 6); });
  ExpectError(ExitCode::kUsage, {"--boards"},
              [] { MarkerBoards(AprilGrid(2, 2, 20), 0); });
}

// Two boards side by side, a camera before them.
ImageDetection SeenTogether(const std::vector<Board>& boards) {
  const auto camera = MakeSimulatedCamera("pinhole", {640, 480});
  const BoardSurface left(boards[0]), right(boards[1]);
  const double width_m = left.paper_m().width();
  const auto pose = [&](double x_m) {
    const Eigen::Vector2d center = left.paper_m().center();
    return Pose{Eigen::Quaterniond::Identity(),
                {x_m - center.x(), -center.y(), 1.75 * width_m}};
  };
  const RenderedImage image =
      RenderImage(PixelRays(*camera, 1),
                  {{&left, pose(-width_m / 2)}, {&right, pose(width_m / 2)}},
                  ImagingOptions(), 1);
  return PatternDetector(Pattern{boards, ""}, {})
      .Detect(MakeGreyImage(AddNoiseAndQuantize(image, ImagingOptions())));
}

void ExpectToldApart(const Board& first) {
  std::vector<Board> boards = MarkerBoards(first, 2);
  for (Board& board : boards) board.points = board.NominalPoints();
  int count[2] = {0, 0};
  for (const Feature& feature : SeenTogether(boards).features)
    ++count[feature.board];
  EXPECT_EQ(count[0], first.num_points());
  EXPECT_EQ(count[1], first.num_points());
}

TEST(MarkerBoards, AreToldApartInAnImage) {
  Board charuco = Charuco(6, 4, 20);
  ExpectToldApart(charuco);
  charuco.dictionary = "DICT_4X4_1000";
  charuco.first_marker = 500;
  ExpectToldApart(charuco);
  ExpectToldApart(AprilGrid(4, 3, 24));
}

TEST(StarBoards, ImpossibleBoardsAreRefused) {
  const auto expect_refused = [](void (*change)(StarBoardOptions*),
                                 const char* word) {
    StarBoardOptions options = Stars(16, 12, 10);
    change(&options);
    ExpectError(ExitCode::kUsage, {word}, [&] { StarBoards(options); });
  };
  expect_refused([](StarBoardOptions* o) { o->segments = 7; }, "--segments");
  expect_refused([](StarBoardOptions* o) { o->segments = 34; }, "--segments");
  expect_refused([](StarBoardOptions* o) { o->num_boards = 0; }, "--boards");
  expect_refused([](StarBoardOptions* o) { o->num_tags = 0; }, "--tags");
  expect_refused([](StarBoardOptions* o) { o->num_tags = 30; }, "--tags");
  expect_refused([](StarBoardOptions* o) { o->tag_squares = 11; },
                 "--tag-squares");
  expect_refused([](StarBoardOptions* o) { o->tag_id = -1; }, "--tag-id");
  expect_refused([](StarBoardOptions* o) { o->columns = 2; }, "--columns");
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

TEST(BoardSheets, PagesAreOfTheirFormat) {
  const BoardSheets sheets = A4Sheet();
  EXPECT_TRUE(StartsWith(SheetsPdf(sheets), "%PDF-"));
  const std::string svg = MakeSheetSvg(sheets, sheets.boards[0]);
  EXPECT_TRUE(StartsWith(svg, "<?xml"));
  EXPECT_NE(svg.find("width=\"297mm\""), std::string::npos);
  EXPECT_NE(svg.find("viewBox=\"0 0 297 210\""), std::string::npos);
  EXPECT_TRUE(
      StartsWith(RenderSheetPng(sheets, sheets.boards[0], 50), "\x89PNG\r\n"));
}

TEST(BoardSheets, PagesAreTheSameEachTime) {
  StarBoardOptions options = Stars(9, 12, 10);
  options.num_boards = 2;
  const BoardSheets sheets =
      PlanBoardSheets(StarBoards(options), ParsePage("A4"));
  const Board& board = sheets.boards[1];
  EXPECT_TRUE(SheetsPdf(sheets) == SheetsPdf(sheets));
  EXPECT_TRUE(MakeSheetSvg(sheets, board) == MakeSheetSvg(sheets, board));
  EXPECT_TRUE(RenderSheetPng(sheets, board, 50) ==
              RenderSheetPng(sheets, board, 50));
  EXPECT_FALSE(MakeSheetSvg(sheets, board) ==
               MakeSheetSvg(sheets, sheets.boards[0]));
}

TEST(BoardSheets, ImpossibleResolutionsAreRefused) {
  const BoardSheets sheets = A4Sheet();
  for (const double dpi : {0.0, -100.0, 1e6, double{NAN}})
    ExpectError(ExitCode::kUsage, {"--dpi"},
                [&] { RenderSheetPng(sheets, sheets.boards[0], dpi); });
}

// The vertices of the first path that is filled black.
std::vector<Eigen::Vector2d> InkVertices(const std::string& svg) {
  size_t at = svg.find("fill:rgb(0%,0%,0%)");
  at = svg.find(" d=\"", at) + 4;
  const std::string path = svg.substr(at, svg.find('"', at) - at);
  std::vector<Eigen::Vector2d> vertices;
  for (size_t i = 0; i < path.size(); ++i)
    if (path[i] == 'L' ||
        (path[i] == 'M' && path.find('L', i) < path.find('M', i + 1))) {
      Eigen::Vector2d p;
      std::sscanf(path.c_str() + i + 1, "%lf %lf", &p.x(), &p.y());
      vertices.push_back(p);
    }
  return vertices;
}

TEST(BoardSheets, SvgIsInMillimetres) {
  const BoardSheets sheets = ChessboardSheet(7, 5, 12.3);
  const auto vertices = InkVertices(MakeSheetSvg(sheets, sheets.boards[0]));
  EXPECT_EQ(vertices.size(), 4u * 24);
  for (const Eigen::Vector2d& p : vertices) {
    const Eigen::Vector2d square =
        (p - Eigen::Vector2d(sheets.board_mm.x0, sheets.board_mm.y0)) / 12.3;
    EXPECT_LT((square - square.array().round().matrix()).cwiseAbs().maxCoeff(),
              0.002 / 12.3);
  }
}

struct DrawnTag {
  int id;
  Eigen::Vector2d corners_px[4];
};

std::vector<DrawnTag> DrawnTags(const std::string& png) {
  const std::vector<uint8_t> bytes(png.begin(), png.end());
  cv::Mat image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  apriltag_family_t* family = tag36h11_create();
  apriltag_detector_t* detector = apriltag_detector_create();
  apriltag_detector_add_family(detector, family);
  image_u8_t view = {image.cols, image.rows, static_cast<int>(image.step),
                     image.data};
  zarray_t* found = apriltag_detector_detect(detector, &view);
  std::vector<DrawnTag> tags;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* detection;
    zarray_get(found, i, &detection);
    DrawnTag tag;
    tag.id = detection->id;
    for (int k = 0; k < 4; ++k)
      tag.corners_px[k] = {detection->p[k][0], detection->p[k][1]};
    tags.push_back(tag);
  }
  apriltag_detections_destroy(found);
  apriltag_detector_destroy(detector);
  tag36h11_destroy(family);
  return tags;
}

TEST(BoardSheets, TagsAreSeenWhereTheyStand) {
  StarBoardOptions options = Stars(16, 23, 11.4);
  options.tag_id = 42;
  const BoardSheets sheets =
      PlanBoardSheets(StarBoards(options), ParsePage("A4"));
  constexpr double kDpi = 150;
  const auto seen = DrawnTags(RenderSheetPng(sheets, sheets.boards[0], kDpi));
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].id, 42);
  const BoardTag& tag = sheets.boards[0].tags[0];
  const double cell_mm = tag.squares * 11.4 / 10;
  // Black from the second cell to the ninth; bottom left first.
  const double left = sheets.board_mm.x0 + (1 + tag.column) * 11.4 + cell_mm;
  const double top = sheets.board_mm.y0 + (1 + tag.row) * 11.4 + cell_mm;
  const double side = 8 * cell_mm;
  const Eigen::Vector2d corners_mm[4] = {{left, top + side},
                                         {left + side, top + side},
                                         {left + side, top},
                                         {left, top}};
  for (int k = 0; k < 4; ++k)
    EXPECT_LT((seen[0].corners_px[k] - corners_mm[k] * kDpi / 25.4).norm(), 1)
        << seen[0].corners_px[k].transpose();
}

TEST(ScreenBoards, SquaresAreWholePixels) {
  const ScreenBoards plan =
      PlanScreenBoards(StarBoards(Stars(16, 9, 10)), {1920, 1080});
  EXPECT_EQ(plan.square_px, 98);
  const std::string png = RenderScreenPng(plan, plan.boards[0]);
  const std::vector<uint8_t> bytes(png.begin(), png.end());
  const cv::Mat image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(image.size(), cv::Size(1920, 1080));
  EXPECT_NEAR(image.at<uint8_t>(2, 2), 128, 1);
  EXPECT_EQ(DrawnTags(png).size(), 1u);
}

TEST(ScreenBoards, LengthsFollowThePixelPitch) {
  const ScreenBoards plan = WithPixelPitch(
      PlanScreenBoards({Charuco(8, 5, 10)}, {1920, 1080}), 101.6);
  const Pattern pattern = ParsePattern("screen", MakeScreenYaml(plan));
  EXPECT_NEAR(pattern.boards[0].square_m, plan.square_px * 0.00025, 1e-9);
  EXPECT_NEAR(pattern.boards[0].marker_m, 0.75 * plan.square_px * 0.00025,
              1e-9);
}

TEST(ScreenBoards, TooSmallScreensAreRefused) {
  ExpectError(ExitCode::kUsage, {"--screen"}, [&] {
    PlanScreenBoards({Chessboard(300, 200, 10)}, {640, 480});
  });
}

}  // namespace
}  // namespace raygrid
