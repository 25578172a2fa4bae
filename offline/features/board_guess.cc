#include "features/board_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "dataset/image_memory_budget.h"
#include "dataset/kinds/target_kind.h"
#include "dataset/parallel_for.h"
#include "features/board_view/low_contrast.h"
#include "features/marker_board_guess.h"
#include "features/squares/chessboard.h"

namespace raygrid {
namespace {

std::optional<Guess> GuessChessboard(const GreyImage& image, const Board&) {
  const auto size = EstimateChessboardSize(image);
  if (!size) return std::nullopt;
  Guess guess;
  guess.kind = "chessboard";
  guess.columns = std::max(size->columns, size->rows);
  guess.rows = std::min(size->columns, size->rows);
  return guess;
}

// Tries the requested kind of target first, because some targets match several
// kinds.
std::optional<Guess> TryBoardKinds(const GreyImage& image, const Board& asked) {
  using Guesser = std::optional<Guess> (*)(const GreyImage&, const Board&);
  std::vector<std::pair<std::string, Guesser>> guessers = {
      {"charuco", GuessCharuco},
      {"aprilgrid", GuessAprilGrid},
      {"chessboard", GuessChessboard}};
  std::stable_partition(
      guessers.begin(), guessers.end(),
      [&](const auto& guesser) { return guesser.first == asked.kind; });
  for (const auto& [kind, guess_kind] : guessers)
    if (const auto guess = guess_kind(image, asked)) return guess;
  return std::nullopt;
}

// Converts a guess to a board.
Board MakeGuessedBoard(const Guess& guess) {
  Board board;
  board.kind = guess.kind;
  board.columns = guess.columns;
  board.rows = guess.rows;
  board.dictionary = DictionaryName(guess.dictionary, guess.max_marker);
  board.tag_family = board.dictionary;
  board.has_corner_squares = guess.has_corner_squares;
  return board;
}

// Swaps columns and rows of a chessboard if the requested one has more rows:
// the orientation of chessboards is ambiguous.
void MatchOrientation(const Board& asked, Guess* guess) {
  if (!guess->HasMarkers() && asked.columns < asked.rows)
    std::swap(guess->columns, guess->rows);
}

// Returns the guess with the most votes of images.
std::optional<Guess> SelectByMajority(
    const std::vector<std::optional<Guess>>& guesses, int* num_votes) {
  std::map<decltype(Guess().Key()), int> votes;
  int num_guesses = 0;
  for (const auto& guess : guesses) {
    if (!guess) continue;
    ++votes[guess->Key()];
    ++num_guesses;
  }
  for (const auto& [key, count] : votes) {
    if (2 * count <= num_guesses ||
        count < std::min<int>(2, static_cast<int>(guesses.size())))
      continue;
    Guess all;
    for (const auto& guess : guesses) {
      if (!guess || guess->Key() != key) continue;
      const Guess before = all;
      all = *guess;
      all.rows = std::max(all.rows, before.rows);
      all.max_marker = std::max(all.max_marker, before.max_marker);
    }
    *num_votes = count;
    return all;
  }
  return std::nullopt;
}

bool HasAllFeatures(const ImageDetection& image, const Board& board) {
  constexpr double kMinVisibleFraction = 0.8;
  return static_cast<double>(image.features.size()) >=
         kMinVisibleFraction * board.num_points();
}

// Inverts the image.
GreyLevels InvertImage(GreyLevels grey) {
  constexpr float kWhite = 255;
  for (float& level : grey.levels) level = kWhite - level;
  return grey;
}

// Returns the number of images that show the pattern inverted (white on black).
// An inverted chessboard also counts.
int CountNegatives(const FolderDetection& found, const Pattern& pattern,
                   const std::vector<int>& chosen, int num_threads) {
  const PatternDetector detector(pattern, {});
  std::vector<int> are_negative(chosen.size(), 0);
  ParallelFor(
      static_cast<int>(chosen.size()), NumThreads(num_threads), [&](int i) {
        const ImageMemoryBudget room(found.dataset.image_size);
        const GreyImage image =
            MakeGreyImage(InvertImage(ReadGreyLevels(found.paths[chosen[i]])));
        if (IsPureNoise(image) || HasLowContrast(image)) return;
        const size_t before = found.images[chosen[i]].features.size();
        are_negative[i] = detector.Detect(image).features.size() > 2 * before;
      });
  return static_cast<int>(
      std::count(are_negative.begin(), are_negative.end(), 1));
}

// Selects images, evenly spread, that do not show the whole board. Returns none
// if enough images show it, or if most show a part of a chessboard: with a
// wrong size, few would be detected.
std::vector<int> SelectExampleImages(const FolderDetection& found,
                                     const Board& board) {
  constexpr int kMaxImages = 5;
  std::vector<int> doubtful;
  const int count = static_cast<int>(found.images.size());
  for (int i = 0; i < count; ++i)
    if (!HasAllFeatures(found.images[i], board)) doubtful.push_back(i);
  const int num_doubtful = static_cast<int>(doubtful.size());
  // Chessboard corners have no IDs: with a wrong size, chessboards are hardly
  // ever detected. Markers may partially match a wrong board.
  const bool is_chessboard = !board.HasMarkers();
  const double min_fraction = is_chessboard ? 0.25 : 0.9;
  if (count - num_doubtful > min_fraction * count) return {};
  const auto num_reported =
      std::count_if(found.images.begin(), found.images.end(),
                    [](const auto& image) { return !image.features.empty(); });
  if (is_chessboard && 2 * num_reported > count) return {};
  const int num_looked_at = std::min(kMaxImages, num_doubtful);
  std::vector<int> chosen;
  for (int k = 0; k < num_looked_at; ++k)
    chosen.push_back(
        doubtful[(2 * k + 1) * num_doubtful / (2 * num_looked_at)]);
  return chosen;
}

std::string SuggestRemedy(const Guess& guess, const Board& asked,
                          const std::string& pattern_name) {
  if (guess.is_mirrored)
    return "mirror the images, or print the board unmirrored";
  if (guess.is_negative) return "print the board in black on white";
  if (!guess.has_corner_squares)
    return fmt::format(
        "use --pattern aprilgrid:{}x{}:LENGTH:no-squares:family={}{}{}, where "
        "LENGTH is the side of a tag",
        guess.columns / 2, guess.rows / 2,
        DictionaryName(guess.dictionary, guess.max_marker),
        guess.border_cells == 1 ? "" : ":border-cells=2",
        guess.is_numbered_from_top ? "" : ":numbered-from=bottom");
  std::string what = "columns and rows";
  if (guess.kind != asked.kind)
    what = "the target kind";
  else if (!HasRequestedMarkers(guess, asked))
    what = KindOf(asked).marker_set_name;
  return fmt::format("correct {} in {}", what, pattern_name);
}

// Returns a warning if most of the images show inverted (white on black)
// boards.
std::optional<std::string> WarnAboutNegatives(const FolderDetection& found,
                                              const Pattern& pattern,
                                              const std::string& pattern_name,
                                              const std::vector<int>& chosen,
                                              int num_threads) {
  // An inverted chessboard is also a chessboard.
  if (chosen.empty() || !pattern.boards.front().HasMarkers())
    return std::nullopt;
  const auto num_seen =
      std::count_if(found.images.begin(), found.images.end(),
                    [](const auto& image) { return !image.features.empty(); });
  if (2 * num_seen > static_cast<std::ptrdiff_t>(found.images.size()))
    return std::nullopt;
  const int count = CountNegatives(found, pattern, chosen, num_threads);
  if (2 * count <= static_cast<int>(chosen.size())) return std::nullopt;
  return fmt::format(
      "the board of {} appears in inverted colours ({} of {} inspected "
      "images); print the board in black on white, or invert the images",
      pattern_name, count, chosen.size());
}

}  // namespace

std::string DescribeExpectedBoards(const Pattern& pattern,
                                   const std::string& pattern_name) {
  const size_t num_others = pattern.boards.size() - 1;
  return fmt::format(
      "searched for {}{}; check that the images are sharp and evenly lit, and "
      "that {} describes their target",
      KindOf(pattern.boards.front()).DescribeSought(pattern.boards.front()),
      num_others > 0 ? fmt::format(" and {} more", num_others) : std::string(),
      pattern_name);
}

std::optional<std::string> SuggestOtherBoard(const FolderDetection& found,
                                             const Pattern& pattern,
                                             const std::string& pattern_name,
                                             int num_threads) {
  const Board& asked = pattern.boards.front();
  const std::vector<int> chosen = SelectExampleImages(found, asked);
  const auto negative = [&] {
    return WarnAboutNegatives(found, pattern, pattern_name, chosen,
                              num_threads);
  };
  if (pattern.boards.size() > 1 || !asked.tags.empty()) return negative();
  std::vector<std::optional<Guess>> guesses(chosen.size());
  ParallelFor(static_cast<int>(chosen.size()), NumThreads(num_threads),
              [&](int i) {
                const ImageMemoryBudget room(found.dataset.image_size);
                const GreyImage image =
                    MakeGreyImage(ReadGreyLevels(found.paths[chosen[i]]));
                if (!IsPureNoise(image) && !HasLowContrast(image))
                  guesses[i] = TryBoardKinds(Denoise(image), asked);
              });
  int num_votes = 0;
  auto guess = SelectByMajority(guesses, &num_votes);
  if (!guess) return negative();
  MatchOrientation(asked, &*guess);
  if (MatchesRequest(*guess, asked)) return negative();
  return fmt::format(
      "the images show {}{} ({} of {} inspected images), not {}; {}",
      guess->is_mirrored   ? "a mirrored board of "
      : guess->is_negative ? "an inverted (white on black) board of "
                           : "",
      KindOf(guess->kind).DescribeLayout(MakeGuessedBoard(*guess)), num_votes,
      chosen.size(), KindOf(asked).DescribeLayout(asked),
      SuggestRemedy(*guess, asked, pattern_name));
}

}  // namespace raygrid
