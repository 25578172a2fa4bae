#include "features/marker_board_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/aruco.hpp>
#include <utility>
#include <vector>

#include "features/squares/aprilgrid.h"
#include "features/squares/detected_markers.h"

namespace raygrid {
namespace {

struct Dictionary {
  int number;  // value of OpenCV's enum
  const char* name;
  bool has_sizes;     // DICT_4X4_50, _100, ...
  bool is_april_tag;  // an AprilTag family
};
constexpr Dictionary kDictionaries[] = {
    {cv::aruco::DICT_4X4_1000, "DICT_4X4", true, false},
    {cv::aruco::DICT_5X5_1000, "DICT_5X5", true, false},
    {cv::aruco::DICT_6X6_1000, "DICT_6X6", true, false},
    {cv::aruco::DICT_7X7_1000, "DICT_7X7", true, false},
    {cv::aruco::DICT_ARUCO_ORIGINAL, "DICT_ARUCO_ORIGINAL", false, false},
    {cv::aruco::DICT_APRILTAG_16h5, "DICT_APRILTAG_16h5", false, true},
    {cv::aruco::DICT_APRILTAG_25h9, "DICT_APRILTAG_25h9", false, true},
    {cv::aruco::DICT_APRILTAG_36h10, "DICT_APRILTAG_36h10", false, true},
    {cv::aruco::DICT_APRILTAG_36h11, "DICT_APRILTAG_36h11", false, true}};

constexpr int kMinMarkers = 4, kMaxMarkers = 1000;
constexpr int kMaxAcross = 24;

// Marker positions, ordered by ID, of a board that is `across` squares or tags
// wide. 1 m corresponds to a square, or to a tag and its gap.
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

// parity: column + row modulo 2 of the squares with markers.
MarkerLayout CharucoLayout(int across, int parity, double marker_fraction) {
  MarkerLayout layout = {across, M_SQRT2, {}};
  for (int row = 0; static_cast<int>(layout.markers.size()) < kMaxMarkers;
       ++row)
    for (int column = 0; column < across; ++column)
      if ((column + row) % 2 == parity)
        layout.markers.push_back(MarkerAt(column + (1 - marker_fraction) / 2,
                                          row + (1 - marker_fraction) / 2,
                                          marker_fraction));
  return layout;
}

MarkerLayout TagLayout(int across, bool is_numbered_from_top,
                       double tag_fraction) {
  MarkerLayout layout = {across, 1, {}};
  for (int k = 0; k < kMaxMarkers; ++k) {
    const int row = k / across;
    layout.markers.push_back(
        MarkerAt(k % across, is_numbered_from_top ? row : -row, tag_fraction));
  }
  return layout;
}

// The layout that is consistent with the most markers.
struct BestLayout {
  int across = 0, num_rows = 0, max_marker = 0;
  int agreement = 0;
  bool is_clear = false;  // nearly all markers are consistent
};

void Compare(const MarkerLayout& layout,
             const std::vector<DetectedMarker>& seen, BestLayout* best) {
  const MarkerConstellation all(layout.markers, layout.pitch_m, seen);
  const int agreement = all.CountConsistent();
  if (agreement <= best->agreement) return;
  const MarkerConstellation consistent = all.SelectConsistent();
  constexpr double kMinConsistentFraction = 0.6, kMinClearFraction = 0.95;
  if (consistent.size() < kMinMarkers ||
      consistent.size() < kMinConsistentFraction * all.size())
    return;
  best->agreement = agreement;
  best->is_clear = consistent.size() >= kMinClearFraction * all.size();
  best->across = layout.across;
  best->max_marker = 0;
  for (const DetectedMarker& marker : consistent.seen())
    best->max_marker = std::max(best->max_marker, marker.index);
  best->num_rows = 1 + static_cast<int>(std::lround(std::fabs(std::floor(
                           layout.markers[best->max_marker].corner.y()))));
}

cv::Ptr<cv::aruco::Dictionary> Predefined(const Dictionary& dictionary) {
  return cv::aruco::getPredefinedDictionary(dictionary.number);
}

// Detected markers of a dictionary, and the number of squares that may be
// markers of any dictionary.
struct DictionaryView {
  std::vector<DetectedMarker> seen;
  int num_squares = 0;
};

DictionaryView MakeDictionaryView(const cv::Mat& readable,
                                  const Dictionary& dictionary,
                                  int first_marker) {
  std::vector<std::vector<cv::Point2f>> corners, others;
  std::vector<int> ids;
  cv::aruco::detectMarkers(readable, Predefined(dictionary), corners, ids,
                           cv::aruco::DetectorParameters::create(), others);
  DictionaryView view;
  view.num_squares = static_cast<int>(corners.size() + others.size());
  for (size_t i = 0; i < ids.size(); ++i) {
    DetectedMarker marker;
    marker.index = ids[i] - first_marker;
    if (marker.index < 0 || marker.index >= kMaxMarkers) continue;
    for (int k = 0; k < 4; ++k)
      marker.corners_px[k] = {corners[i][k].x, corners[i][k].y};
    view.seen.push_back(marker);
  }
  return view;
}

// The requested number comes first; others must match more markers.
std::vector<int> ListSizesToTry(int asked_across) {
  std::vector<int> tries = {asked_across};
  for (int across = 2; across <= kMaxAcross; ++across)
    if (across != asked_across) tries.push_back(across);
  return tries;
}

std::vector<Dictionary> ListDictionariesToTry(const std::string& known_board) {
  std::vector<Dictionary> tries(std::begin(kDictionaries),
                                std::end(kDictionaries));
  std::stable_partition(tries.begin(), tries.end(), [&](const Dictionary& d) {
    return known_board.compare(0, std::string(d.name).size(), d.name) == 0;
  });
  return tries;
}

GreyImage Negative(GreyImage image) {
  for (float& level : image.levels) level = 255 - level;
  for (uint8_t& byte : image.bytes) byte = 255 - byte;
  return image;
}

struct GridTags {
  const char* name;
  int border_cells;
  TagFamily family;
};
constexpr GridTags kGridTags[] = {{"tag36h11", 2, TagFamily::k36h11WideBorder},
                                  {"tag25h9", 2, TagFamily::k25h9WideBorder},
                                  {"tag16h5", 2, TagFamily::k16h5WideBorder},
                                  {"tag36h11", 1, TagFamily::k36h11},
                                  {"tag25h9", 1, TagFamily::k25h9},
                                  {"tag16h5", 1, TagFamily::k16h5}};

// The requested family comes first; for other kinds of boards, the default
// family.
std::vector<GridTags> ListGridTagsToTry(const Board& known_board) {
  std::vector<GridTags> tries(std::begin(kGridTags), std::end(kGridTags));
  std::stable_partition(tries.begin(), tries.end(), [&](const GridTags& t) {
    return known_board.tag_family == t.name &&
           known_board.border_cells == t.border_cells;
  });
  return tries;
}

// Converts detected tags of one family to markers of a board.
std::vector<DetectedMarker> SelectFamilyMarkers(
    const std::vector<DetectedTag>& tags, TagFamily family, int first_marker) {
  std::vector<DetectedMarker> seen;
  for (const DetectedTag& tag : tags) {
    const int index = tag.id - first_marker;
    if (tag.family == family && index >= 0 && index < kMaxMarkers)
      seen.push_back({index, tag.corners});
  }
  return seen;
}

std::vector<DetectedMarker> RotateMarkers(std::vector<DetectedMarker> markers,
                                          int turns) {
  for (DetectedMarker& marker : markers)
    std::rotate(marker.corners_px.begin(), marker.corners_px.begin() + turns,
                marker.corners_px.end());
  return markers;
}

// Updates the best grid layout and the guess with the markers of one family and
// border width, which are stated in kind; the other properties of the guess are
// determined here.
void CompareGrids(const std::vector<DetectedMarker>& seen, Guess kind,
                  const Board& known_board, BestLayout* best, Guess* guess) {
  const bool is_known = known_board.IsTagGrid();
  const double tag_fraction =
      1 / (1 + (is_known ? known_board.spacing_ratio : 0.3));
  if (static_cast<int>(seen.size()) < kMinMarkers) return;
  kind.kind = "aprilgrid";
  kind.has_corner_squares =
      kind.border_cells == 2 && (!is_known || known_board.has_corner_squares);
  const bool is_usual_first =
      is_known ? known_board.is_numbered_from_top : kind.border_cells == 1;
  for (int turns = 0; turns < 4; ++turns) {
    const std::vector<DetectedMarker> turned = RotateMarkers(seen, turns);
    for (const bool from_top : {is_usual_first, !is_usual_first}) {
      for (const int across :
           ListSizesToTry(is_known ? known_board.columns / 2 : 2)) {
        const int before = best->agreement;
        Compare(TagLayout(across, from_top, tag_fraction), turned, best);
        if (best->agreement == before) continue;
        *guess = kind;
        guess->columns = 2 * best->across;
        guess->rows = 2 * best->num_rows;
        guess->max_marker = best->max_marker;
        guess->is_numbered_from_top = from_top;
        if (best->is_clear && MatchesRequest(*guess, known_board)) return;
      }
    }
  }
}

Guess MakeFamilyGuess(const std::string& family, int border_cells) {
  Guess guess;
  guess.dictionary = family;
  guess.border_cells = border_cells;
  return guess;
}

}  // namespace

bool HasRequestedMarkers(const Guess& guess, const Board& known_board) {
  if (known_board.IsTagGrid())
    return known_board.tag_family.compare(0, guess.dictionary.size(),
                                          guess.dictionary) == 0 &&
           guess.border_cells == known_board.border_cells &&
           guess.has_corner_squares == known_board.has_corner_squares;
  return known_board.dictionary.compare(0, guess.dictionary.size(),
                                        guess.dictionary) == 0;
}

bool MatchesRequest(const Guess& guess, const Board& known_board) {
  if (guess.kind != known_board.kind || guess.is_mirrored || guess.is_negative)
    return false;
  if (!guess.HasMarkers())
    return guess.columns == known_board.columns &&
           guess.rows == known_board.rows;
  return guess.columns == known_board.columns &&
         guess.rows <= known_board.rows &&
         guess.is_numbered_from_top == known_board.is_numbered_from_top &&
         HasRequestedMarkers(guess, known_board);
}

std::optional<Guess> GuessCharuco(const GreyImage& image,
                                  const Board& known_board) {
  const bool is_known = !known_board.dictionary.empty();
  const double marker_fraction =
      is_known ? known_board.marker_m / known_board.square_m : 0.75;
  std::vector<MarkerLayout> layouts;
  for (const int across :
       ListSizesToTry(is_known ? known_board.columns + 1 : 3))
    for (const int parity : {0, 1})
      layouts.push_back(CharucoLayout(across, parity, marker_fraction));
  BestLayout best;
  Guess guess;
  enum class ImageVariant { kUnchanged, kMirrored, kNegative };
  for (const ImageVariant shown :
       {ImageVariant::kUnchanged, ImageVariant::kMirrored,
        ImageVariant::kNegative}) {
    if (shown == ImageVariant::kNegative && best.agreement > 0) break;
    const GreyImage changed = shown == ImageVariant::kUnchanged ? image
                              : shown == ImageVariant::kMirrored
                                  ? MirrorImage(image)
                                  : Negative(image);
    const cv::Mat readable = ReadableImage(changed);
    for (const Dictionary& dictionary :
         ListDictionariesToTry(known_board.dictionary)) {
      const auto [seen, num_squares] =
          MakeDictionaryView(readable, dictionary, known_board.first_marker);
      if (num_squares < kMinMarkers) break;  // too few for any dictionary
      if (static_cast<int>(seen.size()) < kMinMarkers) continue;
      for (const MarkerLayout& layout : layouts) {
        const int before = best.agreement;
        Compare(layout, seen, &best);
        if (best.agreement == before) continue;
        guess.kind = "charuco";
        guess.dictionary = dictionary.name;
        guess.is_mirrored = shown == ImageVariant::kMirrored;
        guess.columns = best.across - 1;
        guess.rows = best.num_rows - 1;
        guess.max_marker = best.max_marker;
        guess.is_negative = shown == ImageVariant::kNegative;
        if (best.is_clear && MatchesRequest(guess, known_board)) return guess;
      }
    }
  }
  if (best.agreement == 0) return std::nullopt;
  guess.max_marker += known_board.first_marker;
  return guess;
}

std::optional<Guess> GuessAprilGrid(const GreyImage& image,
                                    const Board& known_board) {
  const std::vector<GridTags> kinds = ListGridTagsToTry(known_board);
  BestLayout best;
  Guess guess;
  // libapriltag also decodes many tags with a different border width: both
  // widths are compared.
  const auto compare = [&](const GreyImage& shown, bool is_mirrored,
                           TagSearch search, bool is_first_family) {
    std::vector<GridTags> tried;
    std::vector<TagFamily> families;
    for (const GridTags& kind : kinds) {
      if ((kind.name == std::string(kinds[0].name)) != is_first_family)
        continue;
      tried.push_back(kind);
      families.push_back(kind.family);
    }
    const auto tags = FindGridTags(shown, families, search);
    for (const GridTags& kind : tried) {
      Guess of_kind = MakeFamilyGuess(kind.name, kind.border_cells);
      of_kind.is_mirrored = is_mirrored;
      CompareGrids(
          SelectFamilyMarkers(tags, kind.family, known_board.first_marker),
          of_kind, known_board, &best, &guess);
    }
  };
  compare(image, false, TagSearch::kThorough, true);
  if (best.is_clear && MatchesRequest(guess, known_board)) return guess;
  compare(MirrorImage(image), true, TagSearch::kQuick, true);
  if (best.agreement > 0) return guess;
  compare(image, false, TagSearch::kQuick, false);
  if (best.agreement > 0) return guess;
  const cv::Mat readable = ReadableImage(image);
  for (const Dictionary& dictionary :
       ListDictionariesToTry(known_board.tag_family)) {
    if (dictionary.is_april_tag) continue;
    const auto [seen, num_squares] =
        MakeDictionaryView(readable, dictionary, known_board.first_marker);
    if (num_squares < kMinMarkers) break;
    CompareGrids(seen, MakeFamilyGuess(dictionary.name, 1), known_board, &best,
                 &guess);
  }
  if (best.agreement == 0) return std::nullopt;
  return guess;
}

std::string DictionaryName(const std::string& name, int max_marker) {
  for (const Dictionary& dictionary : kDictionaries)
    if (dictionary.name == name && dictionary.has_sizes)
      for (const int size : {50, 100, 250, 1000})
        if (max_marker < size) return fmt::format("{}_{}", name, size);
  return name;
}

}  // namespace raygrid
