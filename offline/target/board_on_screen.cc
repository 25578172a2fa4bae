#include "target/board_on_screen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "appearance/board_appearance.h"
#include "dataset/error.h"
#include "target/board_drawing.h"
#include "target/board_yaml.h"

namespace raygrid {
namespace {

constexpr double kMarginSquares = 0.5;  // white border around the target
constexpr double kGrey = 0.5;

// Returns the bounding box of the printed area in squares.
Area ExtentInSquares(const Board& board) {
  const Area extent_m = BoardAppearance(board).extent_m();
  const double s = board.square_m;
  return {extent_m.x0 / s, extent_m.y0 / s, extent_m.x1 / s, extent_m.y1 / s};
}

void RequirePixelPitch(double pixels_per_inch) {
  if (!(pixels_per_inch > 0) || !std::isfinite(pixels_per_inch))
    throw Error(ExitCode::kUsage,
                fmt::format("--dpi {:g}: must be positive", pixels_per_inch));
}

void DrawOnScreen(const ScreenBoards& boards, const Board& board, cairo_t* cr) {
  const Area extent = ExtentInSquares(board);
  const double margin_px = std::floor(kMarginSquares * boards.square_px);
  cairo_set_source_rgb(cr, kGrey, kGrey, kGrey);
  cairo_paint(cr);
  cairo_set_source_rgb(cr, 1, 1, 1);
  cairo_rectangle(
      cr, boards.left_px - margin_px, boards.top_px - margin_px,
      std::ceil(extent.width() * boards.square_px) + 2 * margin_px,
      std::ceil(extent.height() * boards.square_px) + 2 * margin_px);
  cairo_fill(cr);
  DrawBoard(BoardAppearance(board), {boards.left_px, boards.top_px},
            boards.square_px / board.square_m, cr);
}

}  // namespace

ScreenBoards PlanScreenBoards(std::vector<Board> boards,
                              const ImageSize& screen, int requested_px) {
  RequirePossibleBoards(boards);
  const Area extent = ExtentInSquares(boards.front());
  const double largest_px = std::floor(
      std::min(screen.width / (extent.width() + 2 * kMarginSquares),
               screen.height / (extent.height() + 2 * kMarginSquares)) +
      1e-9);
  if (requested_px > largest_px)
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--screen {}x{}: squares of {} pixels do not fit (at most {:g}); "
            "reduce them, or omit --dpi and --square-px for the largest",
            screen.width, screen.height, requested_px, largest_px));
  const double square_px = requested_px != 0 ? requested_px : largest_px;
  if (std::max(screen.width, screen.height) > 32767 || square_px < 4)
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--screen {}x{}: squares would be {:g} pixels wide, below the "
            "minimum of 4 (the screen may have up to 32767 x 32767 pixels)",
            screen.width, screen.height, square_px));
  ScreenBoards plan;
  plan.boards = std::move(boards);
  plan.screen = screen;
  plan.square_px = static_cast<int>(square_px);
  plan.left_px = std::floor((screen.width - extent.width() * square_px) / 2);
  plan.top_px = std::floor((screen.height - extent.height() * square_px) / 2);
  return plan;
}

int SquarePx(const Board& board, double pixels_per_inch) {
  RequirePixelPitch(pixels_per_inch);
  const double square_px = board.square_m / 0.0254 * pixels_per_inch;
  // Limits to a range that contains all practical values.
  return static_cast<int>(std::lround(std::clamp(square_px, 1.0, 1e6)));
}

ScreenBoards WithPixelPitch(ScreenBoards boards, double pixels_per_inch) {
  RequirePixelPitch(pixels_per_inch);
  const double square_m = boards.square_px * 0.0254 / pixels_per_inch;
  for (Board& board : boards.boards) {
    board.marker_m *= square_m / board.square_m;
    board.square_m = square_m;
  }
  return boards;
}

ScreenLength GetMeasurableLength(const Board& board) {
  const Eigen::Vector3d last = board.NominalPoints().back() / board.square_m;
  return {last.x() >= last.y(), std::max(last.x(), last.y())};
}

std::string MakeScreenYaml(const ScreenBoards& boards) {
  const Board& board = boards.boards.front();
  const Area extent = ExtentInSquares(board);
  const double pixel_mm = 1000 * board.square_m / boards.square_px;
  BoardPosition place;
  place.width_mm = boards.screen.width * pixel_mm;
  place.height_mm = boards.screen.height * pixel_mm;
  place.first_feature_mm = {
      (boards.left_px - extent.x0 * boards.square_px) * pixel_mm,
      (boards.top_px - extent.y0 * boards.square_px) * pixel_mm};
  return MakeBoardsYaml(boards.boards, place, {});
}

std::string RenderScreenPng(const ScreenBoards& boards, const Board& board) {
  return RenderPng(boards.screen.width, boards.screen.height,
                   [&](cairo_t* cr) { DrawOnScreen(boards, board, cr); });
}

}  // namespace raygrid
