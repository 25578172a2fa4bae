#include "pattern_input.h"

#include <fmt/format.h>

#include "dataset/error.h"
#include "help_formatter.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

constexpr double kMinSquareM = 0.001, kMaxSquareM = 1;
constexpr double kMaxBoardM = 5;

bool IsLikelySquare(double square_m) {
  return square_m >= kMinSquareM && square_m <= kMaxSquareM;
}

std::string GetSquares(double square_m) {
  return fmt::format("squares of {:g} {}",
                     square_m < 1 ? 1000 * square_m : square_m,
                     square_m < 1 ? "mm" : "m");
}

// Returns the length of a square as given by the option, or in words.
std::string FormatSquareOption(double square_m, const std::string& mm_option) {
  return mm_option.empty() ? GetSquares(square_m)
                           : fmt::format("{} {:g}", mm_option, 1000 * square_m);
}

// Returns the unit that was probably meant, if it makes the square plausible.
std::string Suggestion(double square_m, const std::string& mm_option) {
  for (const double factor : {1e-3, 1e3})
    if (IsLikelySquare(factor * square_m))
      return fmt::format(" (did you mean {}?)",
                         FormatSquareOption(factor * square_m, mm_option));
  return "";
}

double ComputeMaxExtentM(const Board& board) {
  if (board.points.empty()) return 0;
  Eigen::Vector3d low = board.points.front(), high = low;
  for (const Eigen::Vector3d& point : board.points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  return (high - low).maxCoeff();
}

// Returns a question about an implausible size; empty if the size is plausible.
std::string Question(const Board& board, const std::string& mm_option) {
  const bool has_squares = !board.IsPointSet();
  if (has_squares && !IsLikelySquare(board.square_m))
    return fmt::format(
        "{}{} implausible{}", FormatSquareOption(board.square_m, mm_option),
        mm_option.empty()
            ? " are"
            : " gives " + GetSquares(board.square_m) + ", which is",
        Suggestion(board.square_m, mm_option));
  const double max_extent_m = std::max(
      ComputeMaxExtentM(board),
      has_squares ? board.square_m * (std::max(board.columns, board.rows) - 1)
                  : 0);
  if (max_extent_m > kMaxBoardM)
    return fmt::format("a board of {:.3g} m is implausible: {}", max_extent_m,
                       has_squares
                           ? FormatSquareOption(board.square_m, mm_option) +
                                 fmt::format(" with {} x {} features",
                                             board.columns, board.rows)
                           : "xyz must be in metres");
  return "";
}

}  // namespace

CLI::Option* AddPatternOption(CLI::App* command, std::string* pattern,
                              const std::string& warning) {
  return command
      ->add_option("--pattern", *pattern,
                   "target: pattern.yaml or a specification such as "
                   "chessboard:9x6:25mm" +
                       warning)
      ->option_text("FILE|SPEC")
      ->group(help_group::kTarget);
}

Pattern LoadPattern(const std::string& pattern) {
  return ReadPatternOrSpec(pattern);
}

void AddYesOption(CLI::App* command, CommonOptions* common) {
  command
      ->add_flag("--yes", common->yes,
                 "accept unusual lengths: squares outside 1 mm to 1 m, boards "
                 "over 5 m, distances over 20 m")
      ->group(help_group::kTarget);
}

void RequirePlausibleLengths(const std::string& source,
                             const std::vector<Board>& boards,
                             const std::string& mm_option,
                             const CommonOptions& common) {
  if (common.yes) return;
  for (const Board& board : boards) {
    const std::string question = Question(board, mm_option);
    if (!question.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("{}{}; accept with --yes",
                              source.empty() ? "" : source + ": ", question));
  }
}

Pattern LoadCheckedPattern(const std::string& text,
                           const CommonOptions& common) {
  Pattern pattern = LoadPattern(text);
  RequirePlausibleLengths(text, pattern.boards, "", common);
  return pattern;
}

}  // namespace raygrid
