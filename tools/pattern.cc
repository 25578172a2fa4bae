#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.h"
#include "dataset/files.h"
#include "target/chessboard_sheet.h"

namespace raygrid {
namespace {

struct Arguments {
  int columns = 0, rows = 0;
  double square_mm = 0, dpi = 300;
  std::string page = "A4", output;
};

void Run(const Arguments& arguments, const CommonOptions& common) {
  const ChessboardSheet sheet =
      PlanChessboardSheet(arguments.columns, arguments.rows,
                          arguments.square_mm, ParsePage(arguments.page));
  const std::filesystem::path folder = arguments.output;
  OutputFiles files;
  files.Add((folder / "pattern.yaml").string(), ChessboardYaml(sheet));
  files.Add((folder / "pattern.pdf").string(), ChessboardPdf(sheet));
  files.Add((folder / "pattern.svg").string(), ChessboardSvg(sheet));
  files.Add((folder / "pattern.png").string(),
            ChessboardPng(sheet, arguments.dpi));
  files.Commit();
  if (!common.quiet)
    fmt::print(
        "pattern.yaml, pattern.pdf, pattern.svg and pattern.png in {}; "
        "print at 100 % and check the ruler\n",
        arguments.output);
}

}  // namespace

void AddPattern(CLI::App* app, CommonOptions* common) {
  CLI::App* pattern = app->add_subcommand("pattern", "Makes targets to print.");
  pattern->require_subcommand(1);
  CLI::App* command = AddCommand(
      pattern, "chessboard", "A chessboard, with a ruler to check the print.",
      "raygrid pattern chessboard --columns 9 --rows 6 --square-mm 25 -o "
      "board/",
      common);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("--columns", arguments->columns, "inner corners across")
      ->required();
  command->add_option("--rows", arguments->rows, "inner corners down")
      ->required();
  command->add_option("--square-mm", arguments->square_mm, "side of a square")
      ->required();
  command->add_option("--page", arguments->page, "A4, A3, letter or WxHmm")
      ->capture_default_str();
  command->add_option("--dpi", arguments->dpi, "resolution of the PNG")
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "folder to write to")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
