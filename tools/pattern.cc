#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "help_formatter.h"
#include "json_output.h"
#include "pattern_input.h"
#include "target/board_on_screen.h"
#include "target/board_sheet.h"
#include "target/marker_boards.h"
#include "target/star_boards.h"

namespace raygrid {
namespace {

constexpr double kPrintDpi = 300;

/// Options of all targets.
struct OutputOptions {
  std::string page = "A4", screen, output;
  std::optional<double> dpi;
  int square_px = 0;
  double measured_x_mm = 0, measured_y_mm = 0;
};

using MakeBoards = std::function<std::vector<Board>()>;

// "pattern.svg", or "pattern_1.svg" where there are several.
std::string FileName(const std::vector<Board>& boards, const Board& board,
                     const std::string& extension) {
  return boards.size() == 1 ? "pattern." + extension
                            : fmt::format("pattern_{}.{}", board.id, extension);
}

ImageSize ParseScreen(const std::string& text) {
  ImageSize size;
  int length = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%n", &size.width, &size.height,
                  &length) == 2 &&
      length == static_cast<int>(text.size()) && size.width > 0 &&
      size.height > 0)
    return size;
  throw Error(
      ExitCode::kUsage,
      fmt::format("--screen {}: expected WIDTHxHEIGHT in pixels", text));
}

// The boards as pattern.yaml has them, and whatever else there is to tell.
std::string FormatJson(const std::string& yaml, nlohmann::ordered_json json) {
  for (const Board& board : ParsePattern("pattern.yaml", yaml).boards)
    json["boards"].push_back({{"id", board.id},
                              {"kind", board.kind},
                              {"columns", board.columns},
                              {"rows", board.rows},
                              {"square_m", board.square_m}});
  return FormatCommandJson(json);
}

// With the resolution of the screen, squares are as large as asked for; without
// it, what is asked for is what was measured.
ScreenBoards PlanForScreen(const std::vector<Board>& boards,
                           const OutputOptions& options) {
  const ImageSize screen = ParseScreen(options.screen);
  if (!options.dpi) return PlanScreenBoards(boards, screen, options.square_px);
  const int square_px = options.square_px != 0
                            ? options.square_px
                            : SquarePx(boards.front(), *options.dpi);
  return WithPixelPitch(PlanScreenBoards(boards, screen, square_px),
                        *options.dpi);
}

// Says what to measure on the monitor, and what to type then: the same picture
// with its true lengths.
std::string HowToMeasure(const ScreenBoards& plan,
                         const OutputOptions& options) {
  const Board& board = plan.boards.front();
  const ScreenLength length = LengthToMeasure(board);
  const bool is_largest = !options.dpi && options.square_px == 0;
  return fmt::format(
      "measure {:g} squares on the screen, from the first {} of a {} to the "
      "last: {:.2f} mm in pattern.yaml; if you measure L mm, run this command "
      "again with {}{} L/{:g}{}",
      length.squares,
      board.kind == "star"        ? "star's centre"
      : board.kind == "aprilgrid" ? "tag's edge"
                                  : "inner corner",
      length.is_row ? "row" : "column", 1000 * length.squares * board.square_m,
      is_largest ? "" : fmt::format("--square-px {} ", plan.square_px),
      board.kind == "aprilgrid" ? "--tag-mm" : "--square-mm", length.squares,
      options.dpi ? " and without --dpi" : "");
}

void WriteForScreen(const std::vector<Board>& boards,
                    const OutputOptions& options, const CommonOptions& common) {
  const ScreenBoards plan = PlanForScreen(boards, options);
  const std::filesystem::path folder = options.output;
  OutputFiles files;
  const std::string yaml = ScreenYaml(plan);
  files.Add((folder / "pattern.yaml").string(), yaml);
  for (const Board& board : plan.boards)
    files.Add((folder / FileName(boards, board, "png")).string(),
              ScreenPng(plan, board));
  files.Commit();
  if (common.json)
    fmt::print("{}", FormatJson(yaml, {{"square_px", plan.square_px},
                                       {"squares_to_measure",
                                        LengthToMeasure(boards[0]).squares}}));
  else if (!common.quiet)
    fmt::print(
        "pattern.yaml and {} image(s) in {}; display without scaling: squares "
        "are {} pixels wide, {:.4f} mm in pattern.yaml\n{}\n",
        plan.boards.size(), options.output, plan.square_px,
        1000 * plan.boards[0].square_m, HowToMeasure(plan, options));
}

void WriteForPrint(const std::vector<Board>& boards,
                   const OutputOptions& options, const CommonOptions& common) {
  const BoardSheets sheets = PlanBoardSheets(boards, ParsePage(options.page));
  PrintScale scale;
  if (options.measured_x_mm != 0)
    scale = MeasuredScale(sheets, options.measured_x_mm, options.measured_y_mm);
  const std::filesystem::path folder = options.output;
  OutputFiles files;
  const std::string yaml = SheetsYaml(sheets, scale);
  files.Add((folder / "pattern.yaml").string(), yaml);
  files.Add((folder / "pattern.pdf").string(), SheetsPdf(sheets));
  for (const Board& board : sheets.boards) {
    files.Add((folder / FileName(boards, board, "svg")).string(),
              SheetSvg(sheets, board));
    files.Add((folder / FileName(boards, board, "png")).string(),
              SheetPng(sheets, board, options.dpi.value_or(kPrintDpi)));
  }
  files.Commit();
  if (common.json)
    fmt::print("{}", FormatJson(yaml, {{"ruler_mm", sheets.ruler_mm}}));
  else if (!common.quiet)
    fmt::print("pattern.yaml and {} page(s) as PDF, SVG and PNG in {}; {}\n",
               sheets.boards.size(), options.output,
               options.measured_x_mm != 0
                   ? "pattern.yaml has the measured size of the print"
                   : fmt::format("print at 100 % and check that both rulers "
                                 "are {} mm long",
                                 sheets.ruler_mm));
}

void AddOutputOptions(CLI::App* command, OutputOptions* options) {
  BeginGroup(command, help_group::kOutput);
  command->add_option("--page", options->page, "A4, A3, letter or WxHmm")
      ->option_text("SIZE")
      ->capture_default_str();
  command
      ->add_option("--dpi", options->dpi,
                   "resolution of pattern.png (default: 300), or of --screen")
      ->option_text("DPI");
  CLI::Option* const screen =
      command
          ->add_option("--screen", options->screen,
                       "write only a PNG for a monitor of this size in px; "
                       "without --dpi, with the largest squares that fit; "
                       "measure them on the screen")
          ->option_text("WxH");
  command
      ->add_option("--square-px", options->square_px,
                   "with --screen: side length of a square (AprilGrid: tag)")
      ->option_text("PX")
      ->needs(screen)
      ->check(CLI::Range(4, 32767));
  CLI::Option* const x =
      command
          ->add_option("--measured-x-mm", options->measured_x_mm,
                       "measured length of the ruler below the board, to "
                       "correct pattern.yaml for the scale of the print")
          ->option_text("MM");
  CLI::Option* const y =
      command
          ->add_option("--measured-y-mm", options->measured_y_mm,
                       "measured length of the ruler beside the board")
          ->option_text("MM");
  x->needs(y)->excludes(screen)->check(AboveZero());
  y->needs(x)->check(AboveZero());
  command->add_option("-o,--output", options->output, "output folder")
      ->option_text("DIR")
      ->required();
}

// Finishes a command; to be called when the options of the board itself are
// there.
void Finish(CLI::App* command, const MakeBoards& make_boards,
            CommonOptions* common) {
  const auto options = std::make_shared<OutputOptions>();
  AddOutputOptions(command, options.get());
  AddYes(command, common);
  command->callback([command, options, make_boards, common] {
    const std::vector<Board> boards = make_boards();
    AskAboutLengths(
        "", boards,
        command->get_name() == "aprilgrid" ? "--tag-mm" : "--square-mm",
        *common);
    if (options->screen.empty())
      WriteForPrint(boards, *options, *common);
    else
      WriteForScreen(boards, *options, *common);
  });
}

void AddNumBoards(CLI::App* command, int* num_boards) {
  command
      ->add_option("--boards", *num_boards,
                   "number of boards with distinct markers")
      ->option_text("N")
      ->capture_default_str();
}

void AddSize(CLI::App* command, const std::string& what, int* columns,
             int* rows, double* square_mm) {
  BeginGroup(command, help_group::kTarget);
  command->add_option("--columns", *columns, what + " per row")
      ->option_text("N")
      ->required();
  command->add_option("--rows", *rows, what + " per column")
      ->option_text("N")
      ->required();
  command->add_option("--square-mm", *square_mm, "side length of a square")
      ->option_text("MM")
      ->required();
}

void AddStar(CLI::App* pattern, CommonOptions* common) {
  CLI::App* command = AddCommand(
      pattern, "star",
      "Star pattern with an AprilTag, made for generic camera models.",
      "raygrid pattern star --columns 16 --rows 23 --square-mm 11 -o board/",
      common);
  const auto options = std::make_shared<StarBoardOptions>();
  AddSize(command, "features", &options->columns, &options->rows,
          &options->square_mm);
  command
      ->add_option("--segments", options->segments,
                   "number of segments of a star, even, 4 to 32; use fewer for "
                   "blurred or small images")
      ->option_text("N")
      ->capture_default_str();
  command
      ->add_option("--tag-id", options->tag_id,
                   "ID of the first tag (tag36h11)")
      ->option_text("N")
      ->capture_default_str();
  command
      ->add_option("--tags", options->num_tags,
                   "tags per board; more tags allow views of smaller parts")
      ->option_text("N")
      ->capture_default_str();
  command
      ->add_option("--tag-squares", options->tag_squares,
                   "side length of a tag in squares (default: about 40 mm)")
      ->option_text("N")
      ->check(AboveZero());
  AddNumBoards(command, &options->num_boards);
  Finish(
      command, [options] { return StarBoards(*options); }, common);
}

// Two cameras, or two images, do not show by such a board alone which of its
// corners is the first.
void SayIfSymmetric(const Board& board) {
  if (board.NumTurns() < 2) return;
  fmt::print(
      stderr,
      "raygrid: a chessboard of {} x {} corners is symmetric under {} turn, so "
      "its orientation is ambiguous in a single view; use --rows {}\n",
      board.columns, board.rows, board.NumTurns() == 2 ? "half a" : "a quarter",
      board.rows + 1);
}

void AddChessboard(CLI::App* pattern, CommonOptions* common) {
  CLI::App* command = AddCommand(
      pattern, "chessboard", "Chessboard.",
      "raygrid pattern chessboard --columns 9 --rows 6 --square-mm 25 -o "
      "board/",
      common);
  const auto board = std::make_shared<Board>();
  const auto square_mm = std::make_shared<double>();
  AddSize(command, "inner corners", &board->columns, &board->rows,
          square_mm.get());
  const auto make_boards = [board, square_mm, common] {
    board->kind = "chessboard";
    board->square_m = *square_mm / 1000;
    if (!common->quiet) SayIfSymmetric(*board);
    return std::vector<Board>{*board};
  };
  Finish(command, make_boards, common);
}

void AddCharuco(CLI::App* pattern, CommonOptions* common) {
  CLI::App* command =
      AddCommand(pattern, "charuco", "ChArUco board in OpenCV's layout.",
                 "raygrid pattern charuco --columns 8 --rows 5 --square-mm 28 "
                 "--marker-mm 21 -o board/",
                 common);
  const auto board = std::make_shared<Board>();
  const auto square_mm = std::make_shared<double>();
  const auto marker_mm = std::make_shared<double>();
  board->dictionary = "DICT_4X4_50";
  AddSize(command, "inner corners", &board->columns, &board->rows,
          square_mm.get());
  command->add_option("--marker-mm", *marker_mm, "side length of a marker")
      ->option_text("MM")
      ->required();
  command
      ->add_option("--dictionary", board->dictionary,
                   "name of the marker dictionary in OpenCV")
      ->option_text("NAME")
      ->capture_default_str();
  command
      ->add_option("--first-marker", board->first_marker,
                   "ID of the first marker")
      ->option_text("N")
      ->capture_default_str();
  command->add_flag("--legacy", board->is_legacy,
                    "layout of OpenCV before 4.6 (legacy pattern)");
  const auto num_boards = std::make_shared<int>(1);
  AddNumBoards(command, num_boards.get());
  const auto make_boards = [board, square_mm, marker_mm, num_boards] {
    board->kind = "charuco";
    board->square_m = *square_mm / 1000;
    board->marker_m = *marker_mm / 1000;
    return MarkerBoards(*board, *num_boards);
  };
  Finish(command, make_boards, common);
}

struct PlainTags {
  bool has_no_squares = false;
  std::optional<int> border_cells;
  std::optional<std::string> numbered_from;
};

void AddAprilGrid(CLI::App* pattern, CommonOptions* common) {
  CLI::App* command = AddCommand(
      pattern, "aprilgrid",
      "AprilGrid in Kalibr's layout, or a grid of separate tags.",
      "raygrid pattern aprilgrid --tag-columns 6 --tag-rows 6 --tag-mm 24 -o "
      "board/",
      common);
  const auto board = std::make_shared<Board>();
  const auto tag_mm = std::make_shared<double>();
  board->tag_family = "tag36h11";
  board->spacing_ratio = 0.3;
  BeginGroup(command, help_group::kTarget);
  command->add_option("--tag-columns", board->columns, "tags per row")
      ->option_text("N")
      ->required()
      ->check(CLI::Range(1, 500));
  command->add_option("--tag-rows", board->rows, "tags per column")
      ->option_text("N")
      ->required()
      ->check(CLI::Range(1, 500));
  command
      ->add_option("--tag-mm", *tag_mm,
                   "side length of the black square of a tag")
      ->option_text("MM")
      ->required();
  command
      ->add_option("--spacing-ratio", board->spacing_ratio,
                   "gap between tags divided by their side length")
      ->option_text("RATIO")
      ->capture_default_str();
  command
      ->add_option("--family", board->tag_family,
                   "tag36h11, tag25h9 or tag16h5; with --no-squares also "
                   "OpenCV dictionaries such as DICT_4X4_50")
      ->option_text("NAME")
      ->capture_default_str();
  const auto tags = std::make_shared<PlainTags>();
  command->add_flag(
      "--no-squares", tags->has_no_squares,
      "no black squares between tags, as in AprilTag mosaics and OpenCV's "
      "GridBoard");
  command
      ->add_option("--border-cells", tags->border_cells,
                   "width of the black border of a tag, 1 or 2 cells (default: "
                   "2; 1 with --no-squares)")
      ->option_text("N")
      ->check(CLI::Range(1, 2));
  command
      ->add_option("--numbered-from", tags->numbered_from,
                   "row in which the tag IDs start (default: bottom; top with "
                   "--no-squares)")
      ->check(CLI::IsMember({"top", "bottom"}));
  command
      ->add_option("--first-marker", board->first_marker,
                   "ID of the first tag, at the left")
      ->option_text("N")
      ->capture_default_str();
  const auto num_boards = std::make_shared<int>(1);
  AddNumBoards(command, num_boards.get());
  const auto make_boards = [board, tags, tag_mm, num_boards] {
    Board made = *board;
    SetCornerSquares(!tags->has_no_squares, &made);
    made.border_cells = tags->border_cells.value_or(made.border_cells);
    if (tags->numbered_from)
      made.is_numbered_from_top = *tags->numbered_from == "top";
    made.kind = "aprilgrid";
    made.columns *= 2;  // features: two for each tag
    made.rows *= 2;
    made.square_m = *tag_mm / 1000;
    return MarkerBoards(made, *num_boards);
  };
  Finish(command, make_boards, common);
}

}  // namespace

void AddPattern(CLI::App* app, CommonOptions* common) {
  CLI::App* pattern = app->add_subcommand(
      "pattern",
      "Generate calibration targets to print or to show on a monitor.");
  pattern->require_subcommand(1);
  pattern->get_help_ptr()->description("print this help");
  pattern->footer(
      "Other commands accept a specification instead of pattern.yaml:\n"
      "  KIND:COLUMNSxROWS:LENGTH[:NAME=VALUE]...   LENGTH in mm, cm or m\n"
      "  chessboard:9x6:25mm           inner corners, side length of a square\n"
      "  charuco:8x5:28mm:marker=21mm  optional: dictionary, legacy,\n"
      "                                first-marker, boards\n"
      "  aprilgrid:6x6:24mm            tags, side length of a tag; optional:\n"
      "                                family, spacing-ratio, first-marker,\n"
      "                                boards, no-squares, border-cells,\n"
      "                                numbered-from\n"
      "  star:16x23:11mm               features, spacing; optional: segments,\n"
      "                                tags, tag-id, tag-squares, boards\n"
      "\nExample:\n"
      "  raygrid pattern chessboard --columns 9 --rows 6 --square-mm 25 -o "
      "board/");
  AddStar(pattern, common);
  AddChessboard(pattern, common);
  AddCharuco(pattern, common);
  AddAprilGrid(pattern, common);
  for (CLI::App* command : pattern->get_subcommands({}))
    command->group("Targets");
}

}  // namespace raygrid
