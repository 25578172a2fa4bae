#include "features/board_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/aruco.hpp>
#include <tuple>

#include "dataset/image_room.h"
#include "dataset/parallel_for.h"
#include "features/board_view/low_contrast.h"
#include "features/squares/aprilgrid.h"
#include "features/squares/chessboard.h"
#include "features/squares/seen_markers.h"

namespace raygrid {
namespace {

// The guess from one image; columns and rows as in pattern.yaml, only those
// that are seen.
struct Guess {
  std::string kind;
  // The dictionary of a ChArUco board, without its number of markers; an
  // AprilGrid's family.
  std::string dictionary;
  bool is_mirrored = false;
  int columns = 0, rows = 0;
  int max_marker = 0;
  bool is_negative = false;  // white on black

  // The key that guesses from images of one board have in common: rows of
  // markers may be hidden.
  auto Key() const {
    return std::make_tuple(kind, dictionary, is_mirrored, is_negative, columns,
                           kind == "chessboard" ? rows : 0);
  }
};

struct Dictionary {
  int number;  // OpenCV's
  const char* name;
  bool has_sizes;  // DICT_4X4_50, _100, ...
};
constexpr Dictionary kDictionaries[] = {
    {cv::aruco::DICT_4X4_1000, "DICT_4X4", true},
    {cv::aruco::DICT_5X5_1000, "DICT_5X5", true},
    {cv::aruco::DICT_6X6_1000, "DICT_6X6", true},
    {cv::aruco::DICT_7X7_1000, "DICT_7X7", true},
    {cv::aruco::DICT_ARUCO_ORIGINAL, "DICT_ARUCO_ORIGINAL", false},
    {cv::aruco::DICT_APRILTAG_16h5, "DICT_APRILTAG_16h5", false},
    {cv::aruco::DICT_APRILTAG_25h9, "DICT_APRILTAG_25h9", false},
    {cv::aruco::DICT_APRILTAG_36h10, "DICT_APRILTAG_36h10", false},
    {cv::aruco::DICT_APRILTAG_36h11, "DICT_APRILTAG_36h11", false}};

constexpr int kMinMarkers = 4, kMaxMarkers = 1000;
constexpr int kMaxAcross = 24;

// Markers as a board with so many of its squares or tags across has them, in
// the order of their numbers; a square, or a tag with a gap, is 1 m.
struct MarkerLayout {
  int across = 0;
  double pitch_m = 1;
  std::vector<PlacedMarker> markers;
};

PlacedMarker MarkerAt(double x, double y, double side_m) {
  PlacedMarker marker;
  marker.corner = {x, y};
  marker.cell_m = side_m;
  marker.bits.size = 1;
  return marker;
}

// parity: of column + row of the squares that hold markers.
MarkerLayout CharucoLayout(int across, int parity, double marker_part) {
  MarkerLayout layout = {across, M_SQRT2, {}};
  for (int row = 0; static_cast<int>(layout.markers.size()) < kMaxMarkers;
       ++row)
    for (int column = 0; column < across; ++column)
      if ((column + row) % 2 == parity)
        layout.markers.push_back(MarkerAt(column + (1 - marker_part) / 2,
                                          row + (1 - marker_part) / 2,
                                          marker_part));
  return layout;
}

// Rows are counted upwards, as in Kalibr.
MarkerLayout TagLayout(int across, double tag_part) {
  MarkerLayout layout = {across, 1, {}};
  for (int k = 0; k < kMaxMarkers; ++k)
    layout.markers.push_back(
        MarkerAt(k % across, -(k / across), tag_part));  // NOLINT
  return layout;
}

// The layout that the markers confirm best, if it is clearly one.
struct BestLayout {
  int across = 0, num_rows = 0, max_marker = 0;
  int agreement = 0;
  bool is_clear = false;  // hardly a marker is elsewhere
};

void Compare(const MarkerLayout& layout, const std::vector<SeenMarker>& seen,
             BestLayout* best) {
  const MarkerConstellation all(layout.markers, layout.pitch_m, seen);
  const int agreement = all.Agreement();
  if (agreement <= best->agreement) return;
  const MarkerConstellation consistent = all.Consistent();
  constexpr double kMinPart = 0.6, kClearPart = 0.95;
  if (consistent.size() < kMinMarkers ||
      consistent.size() < kMinPart * all.size())
    return;
  best->agreement = agreement;
  best->is_clear = consistent.size() >= kClearPart * all.size();
  best->across = layout.across;
  best->max_marker = 0;
  for (const SeenMarker& marker : consistent.seen())
    best->max_marker = std::max(best->max_marker, marker.index);
  best->num_rows = 1 + static_cast<int>(std::lround(std::fabs(std::floor(
                           layout.markers[best->max_marker].corner.y()))));
}

cv::Ptr<cv::aruco::Dictionary> Predefined(const Dictionary& dictionary) {
  return cv::aruco::getPredefinedDictionary(dictionary.number);
}

std::vector<SeenMarker> SeenOf(const cv::Mat& readable,
                               const Dictionary& dictionary, int first_marker) {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(readable, Predefined(dictionary), corners, ids);
  std::vector<SeenMarker> seen;
  for (size_t i = 0; i < ids.size(); ++i) {
    SeenMarker marker;
    marker.index = ids[i] - first_marker;
    if (marker.index < 0 || marker.index >= kMaxMarkers) continue;
    for (int k = 0; k < 4; ++k)
      marker.corners_px[k] = {corners[i][k].x, corners[i][k].y};
    seen.push_back(marker);
  }
  return seen;
}

bool HasMarkersAsAsked(const Guess& guess, const Board& asked) {
  if (asked.kind == "aprilgrid") return guess.dictionary == asked.tag_family;
  return asked.dictionary.compare(0, guess.dictionary.size(),
                                  guess.dictionary) == 0;
}

bool IsAsAsked(const Guess& guess, const Board& asked) {
  if (guess.kind != asked.kind || guess.is_mirrored || guess.is_negative)
    return false;
  if (guess.kind == "chessboard")
    return guess.columns == asked.columns && guess.rows == asked.rows;
  return guess.columns == asked.columns && guess.rows <= asked.rows &&
         HasMarkersAsAsked(guess, asked);
}

// The number asked for comes first: others must be better.
std::vector<int> AcrossToTry(int asked_across) {
  std::vector<int> tries = {asked_across};
  for (int across = 2; across <= kMaxAcross; ++across)
    if (across != asked_across) tries.push_back(across);
  return tries;
}

std::vector<Dictionary> DictionariesToTry(const std::string& asked) {
  std::vector<Dictionary> tries(std::begin(kDictionaries),
                                std::end(kDictionaries));
  std::stable_partition(tries.begin(), tries.end(), [&](const Dictionary& d) {
    return asked.compare(0, std::string(d.name).size(), d.name) == 0;
  });
  return tries;
}

GreyImage Negative(GreyImage image) {
  for (float& level : image.levels) level = 255 - level;
  for (uint8_t& byte : image.bytes) byte = 255 - byte;
  return image;
}

std::optional<Guess> GuessCharuco(const GreyImage& image, const Board& asked) {
  const bool is_asked = asked.kind == "charuco";
  const double marker_part = is_asked ? asked.marker_m / asked.square_m : 0.75;
  std::vector<MarkerLayout> layouts;
  for (const int across : AcrossToTry(is_asked ? asked.columns + 1 : 3))
    for (const int parity : {0, 1})
      layouts.push_back(CharucoLayout(across, parity, marker_part));
  BestLayout best;
  Guess guess;
  enum class Shown { kAsSeen, kMirrored, kNegative };
  for (const Shown shown :
       {Shown::kAsSeen, Shown::kMirrored, Shown::kNegative}) {
    if (shown == Shown::kNegative && best.agreement > 0) break;
    const GreyImage changed = shown == Shown::kAsSeen     ? image
                              : shown == Shown::kMirrored ? Mirrored(image)
                                                          : Negative(image);
    const cv::Mat readable = ReadableImage(changed);
    for (const Dictionary& dictionary : DictionariesToTry(asked.dictionary)) {
      const std::vector<SeenMarker> seen =
          SeenOf(readable, dictionary, asked.first_marker);
      if (static_cast<int>(seen.size()) < kMinMarkers) continue;
      for (const MarkerLayout& layout : layouts) {
        const int before = best.agreement;
        Compare(layout, seen, &best);
        if (best.agreement == before) continue;
        guess = {"charuco",
                 dictionary.name,
                 shown == Shown::kMirrored,
                 best.across - 1,
                 best.num_rows - 1,
                 best.max_marker,
                 shown == Shown::kNegative};
        if (best.is_clear && IsAsAsked(guess, asked)) return guess;
      }
    }
  }
  if (best.agreement == 0) return std::nullopt;
  guess.max_marker += asked.first_marker;
  return guess;
}

struct GridTags {
  TagFamily family;
  const char* name;
};
constexpr GridTags kGridTags[] = {
    {TagFamily::k36h11WideBorder, "tag36h11"},
    {TagFamily::k25h9WideBorder, "tag25h9"},
    {TagFamily::k16h5WideBorder, "tag16h5"},
    {TagFamily::k36h11, "tag36h11 with a border of one cell"},
    {TagFamily::k25h9, "tag25h9 with a border of one cell"},
    {TagFamily::k16h5, "tag16h5 with a border of one cell"}};

bool IsReadFamily(const std::string& name) {
  return name.find(' ') == std::string::npos;
}

// The family asked for comes first; for other kinds of boards, the usual one.
std::vector<GridTags> GridTagsToTry(const std::string& asked) {
  std::vector<GridTags> tries(std::begin(kGridTags), std::end(kGridTags));
  std::stable_partition(tries.begin(), tries.end(),
                        [&](const GridTags& t) { return asked == t.name; });
  return tries;
}

// Improves on the best layout by the tags of one family.
void CompareTags(const std::vector<DetectedTag>& tags, const GridTags& kind,
                 bool is_mirrored, const Board& asked, BestLayout* best,
                 Guess* guess) {
  const bool is_asked = asked.kind == "aprilgrid";
  const double tag_part = 1 / (1 + (is_asked ? asked.spacing_ratio : 0.3));
  for (int turns = 0; turns < 4; ++turns) {
    std::vector<SeenMarker> seen;
    for (const DetectedTag& tag : tags) {
      SeenMarker marker;
      marker.index = tag.id - asked.first_marker;
      if (tag.family != kind.family || marker.index < 0 ||
          marker.index >= kMaxMarkers)
        continue;
      for (int k = 0; k < 4; ++k)
        marker.corners_px[k] = tag.corners[(k + turns) % 4];
      seen.push_back(marker);
    }
    if (static_cast<int>(seen.size()) < kMinMarkers) return;
    for (const int across : AcrossToTry(is_asked ? asked.columns / 2 : 2)) {
      const int before = best->agreement;
      Compare(TagLayout(across, tag_part), seen, best);
      if (best->agreement == before) continue;
      *guess = {"aprilgrid",      kind.name,          is_mirrored,
                2 * best->across, 2 * best->num_rows, best->max_marker};
      if (best->is_clear && IsAsAsked(*guess, asked)) return;
    }
  }
}

std::optional<Guess> GuessAprilGrid(const GreyImage& image,
                                    const Board& asked) {
  std::vector<GridTags> kinds = GridTagsToTry(asked.tag_family);
  BestLayout best;
  Guess guess;
  for (const bool is_mirrored : {false, true}) {
    const auto tags =
        FindGridTags(is_mirrored ? Mirrored(image) : image, {kinds[0].family});
    CompareTags(tags, kinds[0], is_mirrored, asked, &best, &guess);
    if (best.is_clear && IsAsAsked(guess, asked)) return guess;
  }
  if (best.agreement > 0) return guess;
  kinds.erase(kinds.begin());
  std::vector<TagFamily> families;
  for (const GridTags& kind : kinds) families.push_back(kind.family);
  const auto tags = FindGridTags(image, families, TagSearch::kQuick);
  for (const GridTags& kind : kinds)
    CompareTags(tags, kind, false, asked, &best, &guess);
  if (best.agreement == 0) return std::nullopt;
  return guess;
}

std::optional<Guess> GuessChessboard(const GreyImage& image) {
  const auto size = SeenChessboardSize(image);
  if (!size) return std::nullopt;
  Guess guess;
  guess.kind = "chessboard";
  guess.columns = std::max(size->columns, size->rows);
  guess.rows = std::min(size->columns, size->rows);
  return guess;
}

// The kind that was asked for first: some boards look like several.
std::optional<Guess> GuessFrom(const GreyImage& image, const Board& asked) {
  std::vector<std::string> kinds = {"charuco", "aprilgrid", "chessboard"};
  std::stable_partition(kinds.begin(), kinds.end(),
                        [&](const auto& kind) { return kind == asked.kind; });
  for (const std::string& kind : kinds)
    if (const auto guess = kind == "charuco"     ? GuessCharuco(image, asked)
                           : kind == "aprilgrid" ? GuessAprilGrid(image, asked)
                                                 : GuessChessboard(image))
      return guess;
  return std::nullopt;
}

// A dictionary of ArUco's own, as small as holds a marker.
std::string DictionaryName(const std::string& name, int max_marker) {
  for (const Dictionary& dictionary : kDictionaries)
    if (dictionary.name == name && dictionary.has_sizes)
      for (const int size : {50, 100, 250, 1000})
        if (max_marker < size) return fmt::format("{}_{}", name, size);
  return name;
}

std::string Describe(const std::string& kind, int columns, int rows,
                     const std::string& dictionary) {
  if (kind == "charuco")
    return fmt::format("{} x {} inner corners with markers of {}", columns,
                       rows, dictionary);
  if (kind == "aprilgrid")
    return fmt::format("an AprilGrid of {} x {} tags of {}", columns / 2,
                       rows / 2, dictionary);
  return fmt::format("{} x {} inner corners", columns, rows);
}

std::string MarkersOf(const Board& board) {
  return board.kind == "aprilgrid" ? board.tag_family : board.dictionary;
}

// The other side of a chessboard may be the longer one.
void TurnAs(const Board& asked, Guess* guess) {
  if (guess->kind == "chessboard" && asked.columns < asked.rows)
    std::swap(guess->columns, guess->rows);
}

// The guess that most images agree on.
std::optional<Guess> MostVoted(const std::vector<std::optional<Guess>>& guesses,
                               int* num_votes) {
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

bool IsWhole(const ImageDetection& image, const Board& board) {
  constexpr double kMostOf = 0.8;
  return static_cast<double>(image.features.size()) >=
         kMostOf * board.num_points();
}

// Some of the images that do not show the whole board, evenly spread; none
// where enough do, or where most show a part of a chessboard that is told from
// all others: with another size few would.
std::vector<int> ImagesToLookAt(const FolderDetection& found,
                                const Board& board) {
  constexpr int kMaxImages = 5;
  std::vector<int> doubtful;
  const int count = static_cast<int>(found.images.size());
  for (int i = 0; i < count; ++i)
    if (!IsWhole(found.images[i], board)) doubtful.push_back(i);
  const int num_doubtful = static_cast<int>(doubtful.size());
  // Corners have no numbers: chessboards are seen as they are, or hardly ever.
  // Markers may fit a wrong board in parts.
  const bool is_chessboard = board.kind == "chessboard";
  const double enough = is_chessboard ? 0.25 : 0.9;
  if (count - num_doubtful > enough * count) return {};
  const auto num_told =
      std::count_if(found.images.begin(), found.images.end(),
                    [](const auto& image) { return !image.features.empty(); });
  if (is_chessboard && 2 * num_told > count) return {};
  const int num_looked_at = std::min(kMaxImages, num_doubtful);
  std::vector<int> chosen;
  for (int k = 0; k < num_looked_at; ++k)
    chosen.push_back(
        doubtful[(2 * k + 1) * num_doubtful / (2 * num_looked_at)]);
  return chosen;
}

std::string Remedy(const Guess& guess, const Board& asked,
                   const std::string& pattern_name) {
  if (guess.is_mirrored)
    return "mirror the images back, or print the board the right way round";
  if (guess.is_negative) return "print the board dark on white";
  if (guess.kind == "aprilgrid" && !IsReadFamily(guess.dictionary))
    return "print a board of tags with a border of two cells, with black "
           "squares at their corners (raygrid pattern aprilgrid)";
  std::string what = "columns and rows";
  if (guess.kind != asked.kind)
    what = "the kind of board";
  else if (!HasMarkersAsAsked(guess, asked))
    what = guess.kind == "aprilgrid" ? "the tag family" : "the dictionary";
  return fmt::format("correct {} in {}", what, pattern_name);
}

// The board, and what of it is read.
std::string DescribeSought(const Board& board) {
  const std::string size =
      Describe(board.kind, board.columns, board.rows, MarkersOf(board));
  if (board.kind == "charuco")
    return fmt::format("a ChArUco board of {}, dark on white", size);
  if (board.kind == "aprilgrid")
    return size +
           ", with a border of two cells and black squares at their "
           "corners";
  if (board.kind == "star")
    return fmt::format("a star board of {} x {} stars with tag {} of {}",
                       board.columns, board.rows, board.tags.front().id,
                       board.tags.front().family);
  return "a chessboard of " + size;
}

}  // namespace

std::string SoughtBoards(const Pattern& pattern,
                         const std::string& pattern_name) {
  const size_t num_others = pattern.boards.size() - 1;
  return fmt::format(
      "searched for {}{}; check that {} says what they show",
      DescribeSought(pattern.boards.front()),
      num_others > 0 ? fmt::format(" and {} more", num_others) : std::string(),
      pattern_name);
}

std::optional<std::string> GuessOtherBoard(const FolderDetection& found,
                                           const Pattern& pattern,
                                           const std::string& pattern_name,
                                           int num_threads) {
  const Board& asked = pattern.boards.front();
  if (pattern.boards.size() > 1 ||
      (asked.kind != "chessboard" && asked.kind != "charuco" &&
       asked.kind != "aprilgrid"))
    return std::nullopt;
  const std::vector<int> chosen = ImagesToLookAt(found, asked);
  std::vector<std::optional<Guess>> guesses(chosen.size());
  ParallelFor(static_cast<int>(chosen.size()), NumThreads(num_threads),
              [&](int i) {
                const ImageRoom room(found.dataset.image_size);
                const GreyImage image =
                    MakeGreyImage(ReadGreyLevels(found.paths[chosen[i]]));
                if (!IsNoiseAlone(image) && !HasHardlyAnyContrast(image))
                  guesses[i] = GuessFrom(WithLittleNoise(image), asked);
              });
  int num_votes = 0;
  auto guess = MostVoted(guesses, &num_votes);
  if (!guess) return std::nullopt;
  TurnAs(asked, &*guess);
  if (IsAsAsked(*guess, asked)) return std::nullopt;
  return fmt::format(
      "this looks like {}{} ({} of {} images looked at), not {}; {}",
      guess->is_mirrored   ? "a mirrored board of "
      : guess->is_negative ? "a board printed white on black of "
                           : "",
      Describe(guess->kind, guess->columns, guess->rows,
               DictionaryName(guess->dictionary, guess->max_marker)),
      num_votes, chosen.size(),
      Describe(asked.kind, asked.columns, asked.rows, MarkersOf(asked)),
      Remedy(*guess, asked, pattern_name));
}

}  // namespace raygrid
