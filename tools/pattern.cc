#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
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

namespace raygrid {
namespace {

constexpr double kPrintDpi = 300;

// Options of all targets.
struct OutputOptions {
  std::string page = "A4", screen, output;
  std::optional<double> dpi;
  int square_px = 0;
  double measured_x_mm = 0, measured_y_mm = 0;
};

// Returns "pattern.svg", or "pattern_1.svg" if there are several boards.
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

// Completes the JSON output by the boards as in pattern.yaml.
std::string FormatJson(const std::string& yaml, nlohmann::ordered_json json) {
  for (const Board& board : ParsePattern("pattern.yaml", yaml).boards)
    json["boards"].push_back({{"id", board.id},
                              {"kind", board.kind},
                              {"columns", board.columns},
                              {"rows", board.rows},
                              {"square_m", board.square_m}});
  return FormatCommandJson(json);
}

// If the screen's resolution is given, squares get the requested size;
// otherwise the requested size is assumed to have been measured.
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

// Explains what to measure on the monitor, and how to run the command again to
// get the same picture with its true lengths.
std::string DescribeMeasurement(const ScreenBoards& plan,
                                const OutputOptions& options) {
  const Board& board = plan.boards.front();
  const ScreenLength length = GetMeasurableLength(board);
  const bool is_largest = !options.dpi && options.square_px == 0;
  return fmt::format(
      "measure {:g} squares on the screen, from the first {} of a {} to the "
      "last: {:.2f} mm in pattern.yaml; if you measure L mm, run this command "
      "again with {}{} L/{:g}{}",
      length.squares, KindOf(board).feature_name,
      length.is_row ? "row" : "column", 1000 * length.squares * board.square_m,
      is_largest ? "" : fmt::format("--square-px {} ", plan.square_px),
      KindOf(board).LengthOption(), length.squares,
      options.dpi ? " and without --dpi" : "");
}

void WriteForScreen(const std::vector<Board>& boards,
                    const OutputOptions& options, const CommonOptions& common) {
  const ScreenBoards plan = PlanForScreen(boards, options);
  const std::filesystem::path folder = options.output;
  OutputFiles files;
  const std::string yaml = MakeScreenYaml(plan);
  files.Add((folder / "pattern.yaml").string(), yaml);
  for (const Board& board : plan.boards)
    files.Add((folder / FileName(boards, board, "png")).string(),
              RenderScreenPng(plan, board));
  files.Commit();
  if (common.json)
    fmt::print("{}",
               FormatJson(yaml, {{"square_px", plan.square_px},
                                 {"squares_to_measure",
                                  GetMeasurableLength(boards[0]).squares}}));
  else if (!common.quiet)
    fmt::print(
        "pattern.yaml and {} {} in {}; display without scaling: squares are {} "
        "pixels wide, {:.4f} mm in pattern.yaml\n{}\n",
        plan.boards.size(), plan.boards.size() == 1 ? "image" : "images",
        options.output, plan.square_px, 1000 * plan.boards[0].square_m,
        DescribeMeasurement(plan, options));
}

void WriteForPrint(const std::vector<Board>& boards,
                   const OutputOptions& options, const CommonOptions& common) {
  const BoardSheets sheets = PlanBoardSheets(boards, ParsePage(options.page));
  PrintScale scale;
  if (options.measured_x_mm != 0)
    scale =
        ComputePrintScale(sheets, options.measured_x_mm, options.measured_y_mm);
  const std::filesystem::path folder = options.output;
  OutputFiles files;
  const std::string yaml = MakeSheetsYaml(sheets, scale);
  files.Add((folder / "pattern.yaml").string(), yaml);
  files.Add((folder / "pattern.pdf").string(), SheetsPdf(sheets));
  for (const Board& board : sheets.boards) {
    files.Add((folder / FileName(boards, board, "svg")).string(),
              MakeSheetSvg(sheets, board));
    files.Add((folder / FileName(boards, board, "png")).string(),
              RenderSheetPng(sheets, board, options.dpi.value_or(kPrintDpi)));
  }
  files.Commit();
  if (common.json)
    fmt::print("{}", FormatJson(yaml, {{"ruler_mm", sheets.ruler_mm}}));
  else if (!common.quiet)
    fmt::print("pattern.yaml and {} {} as PDF, SVG and PNG in {}; {}\n",
               sheets.boards.size(),
               sheets.boards.size() == 1 ? "page" : "pages", options.output,
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
                   "resolution of pattern.png (default: 300), or of the "
                   "monitor passed to --screen")
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

// Adds the options of a target kind to its command.
class CommandOptions : public BoardOptions {
 public:
  explicit CommandOptions(CLI::App* command) : command_(command) {}

  void Number(const char* name, const char* help, int* value) override {
    Add(name, help, value)->option_text("N")->capture_default_str();
  }
  void Number(const char* name, const char* help, double* value) override {
    Add(name, help, value)->option_text("RATIO")->capture_default_str();
  }
  void Number(const char* name, const char* help, int max,
              std::optional<int>* value) override {
    Add(name, help, value)
        ->option_text("N")
        ->check(max > 0 ? CLI::Range(1, max) : AboveZero());
  }
  void Text(const char* name, const char* help, std::string* value) override {
    Add(name, help, value)->option_text("NAME")->capture_default_str();
  }
  void Word(const char* name, const char* help,
            const std::vector<std::string>& words,
            std::optional<std::string>* value) override {
    Add(name, help, value)->check(CLI::IsMember(words));
  }
  void Flag(const char* name, const char* help, bool* value) override {
    command_->add_flag(std::string("--") + name, *value, help);
  }
  void Length(const char* name, const char* help, double* value_mm) override {
    Add(name + std::string("-mm"), help, value_mm)
        ->option_text("MM")
        ->required();
  }

 private:
  template <typename T>
  CLI::Option* Add(const std::string& name, const char* help, T* value) {
    return command_->add_option("--" + name, *value, help);
  }

  CLI::App* command_;
};

void AddSize(CLI::App* command, const TargetKind& kind, BoardRequest* request) {
  const auto add_count = [&](const char* word, const char* side, int* count) {
    CLI::Option* const option =
        command
            ->add_option(kind.OptionName(word), *count,
                         std::string(kind.counted_name) + side)
            ->option_text("N")
            ->required();
    if (kind.max_count > 0) option->check(CLI::Range(1, kind.max_count));
  };
  add_count("columns", " per row", &request->board.columns);
  add_count("rows", " per column", &request->board.rows);
  command->add_option(kind.LengthOption(), request->length_mm, kind.length_help)
      ->option_text("MM")
      ->required();
}

// Warns if the board is rotationally symmetric: its first corner is then
// ambiguous between cameras and between images.
void WarnIfSymmetric(const Board& board) {
  if (board.NumRotations() < 2) return;
  fmt::print(
      stderr,
      "raygrid: a chessboard of {} x {} corners is symmetric under {} turn, so "
      "its orientation is ambiguous in a single view; use --rows {}\n",
      board.columns, board.rows,
      board.NumRotations() == 2 ? "half a" : "a quarter", board.rows + 1);
}

void AddKind(CLI::App* pattern, const TargetKind& kind, CommonOptions* common) {
  CLI::App* command = AddCommand(
      pattern, kind.name, kind.summary,
      fmt::format("raygrid pattern {} {} -o board/", kind.name, kind.example),
      common);
  command->group("Targets");
  const auto request = std::make_shared<BoardRequest>();
  BeginGroup(command, help_group::kTarget);
  AddSize(command, kind, request.get());
  CommandOptions target(command);
  kind.AddOptions(&target, request.get());
  const auto options = std::make_shared<OutputOptions>();
  AddOutputOptions(command, options.get());
  AddYesOption(command, common);
  command->callback([&kind, request, options, common] {
    const std::vector<Board> boards = MakeBoards(kind, *request);
    if (!common->quiet) WarnIfSymmetric(boards.front());
    RequirePlausibleLengths("", boards, kind.LengthOption(), *common);
    if (options->screen.empty())
      WriteForPrint(boards, *options, *common);
    else
      WriteForScreen(boards, *options, *common);
  });
}

// Returns the target specifications of all kinds, in two columns.
std::string SpecificationsHelp() {
  std::string lines;
  for (const auto& kind : TargetKinds()) {
    std::string first = kind->specification;
    for (const char* line : kind->specification_help) {
      lines += fmt::format("  {:<28}  {}\n", first, line);
      first.clear();
    }
  }
  return lines;
}

}  // namespace

void AddPattern(CLI::App* app, CommonOptions* common) {
  CLI::App* pattern = app->add_subcommand(
      "pattern",
      "Generate calibration targets to print or to show on a monitor.");
  pattern->require_subcommand(1);
  pattern->get_help_ptr()->description("print this help");
  pattern->footer(
      std::string(
          "Other commands accept a specification instead of pattern.yaml:\n"
          "  KIND:COLUMNSxROWS:LENGTH[:NAME=VALUE]...   LENGTH in mm, cm or "
          "m\n") +
      SpecificationsHelp() +
      "\nExample:\n"
      "  raygrid pattern chessboard --columns 9 --rows 6 --square-mm 25 -o "
      "board/");
  for (const auto& kind : TargetKinds())
    if (kind->is_drawable) AddKind(pattern, *kind, common);
}

}  // namespace raygrid
