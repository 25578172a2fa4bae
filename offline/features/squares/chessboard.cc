#include "features/squares/chessboard.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "features/board_view/locators.h"
#include "features/squares/chess_lattice.h"
#include "features/squares/corner_growth.h"
#include "features/squares/corner_matching.h"

namespace raygrid {

/// Detects the inner corners of a chessboard approximately, in images of the
/// complete board or a region of it.
///
/// The first corner is determined by the colours: the square to its lower right
/// is dark. This is unique if one side of the board is even and the other odd;
/// otherwise the candidate for which the board is most upright in the image is
/// chosen. A board whose colours show that it is mirrored is numbered as before
/// mirroring, with a warning.
///
/// Corners have no IDs: a partially visible board is numbered only if its
/// visible edges, its size and its colours leave a single possibility.
/// Otherwise no features are returned, and a warning.
class ChessboardLocator {
 public:
  explicit ChessboardLocator(const Board& board);
  ~ChessboardLocator();

  ImageDetection Locate(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

namespace {

bool IsEven(int value) { return value % 2 == 0; }

// A rectangle of lattice positions, inclusive.
struct Rectangle {
  int left = 0, top = 0, right = -1, bottom = -1;

  int columns() const { return right - left + 1; }
  int rows() const { return bottom - top + 1; }
  bool operator<(const Rectangle& other) const {
    return std::tie(left, top, right, bottom) <
           std::tie(other.left, other.top, other.right, other.bottom);
  }
};

Rectangle Bounds(const FeatureLattice& lattice) {
  Rectangle bounds;
  for (const Feature& f : lattice.Features()) {
    if (bounds.columns() < 1) bounds = {f.column, f.row, f.column, f.row};
    bounds.left = std::min(bounds.left, f.column);
    bounds.top = std::min(bounds.top, f.row);
    bounds.right = std::max(bounds.right, f.column);
    bounds.bottom = std::max(bounds.bottom, f.row);
  }
  return bounds;
}

// Whether most of the corners of a row or column that are predicted to be in
// the image were detected.
bool HasMostFeatures(const GreyImage& image, const FeatureLattice& lattice,
                     const Rectangle& line) {
  constexpr int kMinFound = 2;
  int num_found = 0, num_missing = 0;
  for (int row = line.top; row <= line.bottom; ++row) {
    for (int column = line.left; column <= line.right; ++column) {
      LocalMapping prediction;
      if (lattice.Has(column, row))
        ++num_found;
      else if (PredictFeature(lattice, column, row, &prediction))
        num_missing += WholeImage(image.size)
                           .Contains(prediction.center,
                                     -prediction.linear.cwiseAbs().maxCoeff());
    }
  }
  return num_found >= kMinFound && num_found > num_missing;
}

// Contrast between the white and black squares around a corner, in grey levels:
// on the side of (to_column, to_row), and on the opposite side.
struct SideContrast {
  double outside = 0, inside = 0;
};

// Returns nullopt unless all four squares are in the image.
std::optional<SideContrast> ComputeSideContrast(const GreyImage& image,
                                                const FeatureLattice& lattice,
                                                int column, int row,
                                                int to_column, int to_row) {
  LocalMapping mapping;
  if (!PredictFeature(lattice, column, row, &mapping)) return std::nullopt;
  mapping.center = lattice.at(column, row);
  constexpr double kOffset = 0.25;  // squares
  SideContrast contrast;
  for (const double x : {-kOffset, kOffset}) {
    for (const double y : {-kOffset, kOffset}) {
      const auto level = ComputeMeanGreyLevel(image, mapping, {x, y});
      if (!level) return std::nullopt;
      const bool is_black = ((x > 0) == (y > 0)) == IsEven(column + row);
      (x * to_column + y * to_row > 0 ? contrast.outside : contrast.inside) +=
          is_black ? -*level : *level;
    }
  }
  return contrast;
}

// Whether the squares continue outside the outermost row or column of corners
// in the direction of (to_column, to_row). Where the last squares of a board
// border on a background of medium brightness, the image correlates with a
// corner by 0.71, nearly the required minimum.
bool AlternatesOutside(const GreyImage& image, const FeatureLattice& lattice,
                       const Rectangle& line, int to_column, int to_row) {
  SideContrast sum;
  for (int row = line.top; row <= line.bottom; ++row) {
    for (int column = line.left; column <= line.right; ++column) {
      if (!lattice.Has(column, row)) continue;
      const auto contrast =
          ComputeSideContrast(image, lattice, column, row, to_column, to_row);
      if (!contrast) continue;
      sum.outside += contrast->outside;
      sum.inside += contrast->inside;
    }
  }
  constexpr double kMinPart = 0.5;
  return sum.outside >= kMinPart * sum.inside;
}

// Whether an outermost row or column of the lattice belongs to a board.
bool IsBoardLine(const GreyImage& image, const FeatureLattice& lattice,
                 const Rectangle& line, int to_column, int to_row) {
  return HasMostFeatures(image, lattice, line) &&
         AlternatesOutside(image, lattice, line, to_column, to_row);
}

// Returns the lattice without spurious outer rows and columns: background next
// to a board may resemble squares.
Rectangle ComputeReliableRectangle(const GreyImage& image,
                                   const FeatureLattice& lattice) {
  Rectangle part = Bounds(lattice);
  for (;;) {
    if (part.columns() < 1 || part.rows() < 1) return part;
    const auto [left, top, right, bottom] = part;
    if (!IsBoardLine(image, lattice, {left, top, left, bottom}, -1, 0))
      ++part.left;
    else if (!IsBoardLine(image, lattice, {right, top, right, bottom}, 1, 0))
      --part.right;
    else if (!IsBoardLine(image, lattice, {left, top, right, top}, 0, -1))
      ++part.top;
    else if (!IsBoardLine(image, lattice, {left, bottom, right, bottom}, 0, 1))
      --part.bottom;
    else
      return part;
  }
}

// The position one square outside an outermost corner, where the outermost
// squares end if the corner is the board's last one.
struct OutsideCorner {
  LocalMapping mapping;  // prediction
  int to_column = 0, to_row = 0;
  bool is_dark = false;  // to the lower right, if there were a corner

  bool IsOutside(const Eigen::Vector2d& offset) const {
    return offset.x() * to_column + offset.y() * to_row > 0;
  }
  bool IsBlack(const Eigen::Vector2d& offset) const {
    return !IsOutside(offset) &&
           ((offset.x() > 0) == (offset.y() > 0)) == is_dark;
  }
};

// Whether the surroundings of a board are as bright as its white squares
// (paper), not an occluding object.
bool IsPaperOutside(const GreyImage& image, const OutsideCorner& place) {
  double black = 0, white = 0;
  std::vector<double> outside;
  for (const double x : {-0.3, 0.3}) {
    for (const double y : {-0.3, 0.3}) {
      const Eigen::Vector2d offset(x, y);
      const auto level = ComputeMeanGreyLevel(image, place.mapping, offset);
      if (!level) return false;
      if (place.IsOutside(offset))
        outside.push_back(*level);
      else
        (place.IsBlack(offset) ? black : white) = *level;
    }
  }
  constexpr double kTolerance = 0.15;  // fraction of the contrast
  return std::all_of(outside.begin(), outside.end(), [&](double level) {
    return std::fabs(level - white) < kTolerance * (white - black);
  });
}

// Whether the squares outside the outermost corners are visibly the last ones,
// surrounded by paper.
bool IsBoardEndOnSide(const GreyImage& image, const FeatureLattice& lattice,
                      const Rectangle& part, int to_column, int to_row) {
  int num_seen = 0, num_ends = 0;
  for (int row = part.top; row <= part.bottom; ++row) {
    for (int column = part.left; column <= part.right; ++column) {
      const bool is_outermost = to_column < 0   ? column == part.left
                                : to_column > 0 ? column == part.right
                                : to_row < 0    ? row == part.top
                                                : row == part.bottom;
      if (!is_outermost || !lattice.Has(column, row)) continue;
      const int outside_column = column + to_column, outside_row = row + to_row;
      OutsideCorner place = {
          {}, to_column, to_row, IsEven(outside_column + outside_row)};
      if (!lattice.IsOnBoard(outside_column, outside_row) ||
          !PredictFeature(lattice, outside_column, outside_row, &place.mapping))
        continue;
      const DrawnPatch end(0.5, [&](const Eigen::Vector2d& offset) {
        return place.IsBlack(offset);
      });
      constexpr double kSearchSquares = 0.12, kMinCorrelation = 0.72;
      constexpr double kMinVisible = 0.9;
      const PatchCorrelation match =
          FindPatch(image, end, place.mapping,
                    std::max(1.0, kSearchSquares * place.mapping.SpacingPx()),
                    kMinVisible);
      if (match.correlation <= -1) continue;
      ++num_seen;
      place.mapping.center = match.pixel;
      num_ends +=
          match.correlation > kMinCorrelation && IsPaperOutside(image, place);
    }
  }
  constexpr int kMinEnds = 2;
  return num_ends >= kMinEnds && 3 * num_ends >= 2 * num_seen;
}

// Assignment of lattice positions to the corners of a board.
struct Numbering {
  Rectangle place;        // position of the board on the lattice
  int quarter_turns = 0;  // rotation of the board, clockwise in the image
  bool is_mirrored = false;

  // Converts lattice coordinates to column and row on the board.
  std::array<int, 2> Of(const Board& board, int column, int row) const {
    const int i = column - place.left, j = row - place.top;
    const int last_column = board.columns - 1, last_row = board.rows - 1;
    const std::array<int, 2> upright =
        quarter_turns == 0   ? std::array{i, j}
        : quarter_turns == 1 ? std::array{j, last_row - i}
        : quarter_turns == 2 ? std::array{last_column - i, last_row - j}
                             : std::array{last_column - j, i};
    if (is_mirrored) return {last_column - upright[0], upright[1]};
    return upright;
  }

  // The square to the lower right of features with even column + row is dark.
  bool HasExpectedColors(const Board& board) const {
    const auto [column, row] = Of(board, place.left, place.top);
    const bool is_dark =
        IsEven(place.left + place.top + quarter_turns + is_mirrored);
    return IsEven(column + row) == is_dark;
  }
};

// Returns the image directions of a row of the board after 0 to 3 rotations by
// 90 degrees.
std::array<Eigen::Vector2d, 4> Directions(const FeatureLattice& lattice) {
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  Eigen::Vector2d down = Eigen::Vector2d::Zero();
  for (const Feature& f : lattice.Features()) {
    if (lattice.Has(f.column + 1, f.row))
      right += lattice.at(f.column + 1, f.row) - f.pixel;
    if (lattice.Has(f.column, f.row + 1))
      down += lattice.at(f.column, f.row + 1) - f.pixel;
  }
  right.normalize();
  down.normalize();
  return {right, down, -right, -down};
}

const Numbering& SelectMostUpright(const std::vector<Numbering>& numberings,
                                   const FeatureLattice& lattice) {
  const auto directions = Directions(lattice);
  const auto uprightness = [&](const Numbering& numbering) {
    const double x = directions[numbering.quarter_turns].x();
    return numbering.is_mirrored ? -x : x;
  };
  return *std::max_element(numberings.begin(), numberings.end(),
                           [&](const Numbering& a, const Numbering& b) {
                             return uprightness(a) < uprightness(b);
                           });
}

// Edges of a lattice rectangle that are known to be edges of the board.
struct BoardEnds {
  bool left = false, top = false, right = false, bottom = false;
};

// Returns the possible positions of a board on the lattice that contain the
// rectangle `part` of it; edges marked in `ends` must coincide.
std::vector<Rectangle> ListPossiblePositions(const Rectangle& part,
                                             const BoardEnds& ends, int columns,
                                             int rows) {
  std::vector<Rectangle> places;
  for (int top = part.bottom - rows + 1; top <= part.top; ++top) {
    for (int left = part.right - columns + 1; left <= part.left; ++left) {
      const Rectangle place = {left, top, left + columns - 1, top + rows - 1};
      if ((!ends.left || place.left == part.left) &&
          (!ends.top || place.top == part.top) &&
          (!ends.right || place.right == part.right) &&
          (!ends.bottom || place.bottom == part.bottom))
        places.push_back(place);
    }
  }
  return places;
}

}  // namespace

struct ChessboardLocator::Data {
  explicit Data(const Board& b)
      : board(b), finder(std::max(b.columns, b.rows)), growth(b) {}

  Board board;
  ChessLatticeFinder finder;
  CornerGrowth growth;

  std::vector<Numbering> ListNumberings(const Rectangle& part,
                                        const BoardEnds& ends,
                                        bool is_mirrored) const;
  std::optional<Numbering> AssignNumbers(const GreyImage& image,
                                         const FeatureLattice& lattice,
                                         const Rectangle& part,
                                         std::string* warning) const;
};

// Returns all possibilities regardless of colours.
std::vector<Numbering> ChessboardLocator::Data::ListNumberings(
    const Rectangle& part, const BoardEnds& ends, bool is_mirrored) const {
  std::vector<Numbering> numberings;
  for (int turns = 0; turns < 4; ++turns) {
    const int columns = IsEven(turns) ? board.columns : board.rows;
    const int rows = IsEven(turns) ? board.rows : board.columns;
    for (const Rectangle& place :
         ListPossiblePositions(part, ends, columns, rows))
      numberings.push_back({place, turns, is_mirrored});
  }
  return numberings;
}

// Numbers the corners of a region of the lattice if there is a single
// possibility; otherwise sets the warning.
std::optional<Numbering> ChessboardLocator::Data::AssignNumbers(
    const GreyImage& image, const FeatureLattice& lattice,
    const Rectangle& part, std::string* warning) const {
  const auto right_ones = [&](std::vector<Numbering> numberings) {
    numberings.erase(
        std::remove_if(numberings.begin(), numberings.end(),
                       [&](const Numbering& numbering) {
                         return !numbering.HasExpectedColors(board);
                       }),
        numberings.end());
    return numberings;
  };
  const auto is_unambiguous = [](const std::vector<Numbering>& numberings) {
    for (const Numbering& numbering : numberings)
      if (numbering.place < numberings[0].place ||
          numberings[0].place < numbering.place)
        return false;
    return !numberings.empty();
  };
  const std::vector<Numbering> all = ListNumberings(part, {}, false);
  const auto unlike_board = [&] {
    return fmt::format(
        "a chessboard of {} x {} corners, which does not match board {}",
        part.columns(), part.rows(), board.id);
  };
  if (all.empty()) {
    *warning = unlike_board();
    return std::nullopt;
  }
  std::vector<Numbering> right = right_ones(all);
  if (is_unambiguous(right)) return SelectMostUpright(right, lattice);
  if (right.empty()) {
    // If both sides are odd, mirroring swaps the colours; if both are even,
    // only inverted printing does.
    const bool is_mirrored = !IsEven(board.columns) && !IsEven(board.rows);
    *warning = fmt::format(
        is_mirrored ? "board {} is mirrored, or its colours are inverted"
                    : "the colours of board {} are inverted",
        board.id);
    return SelectMostUpright(ListNumberings(part, {}, is_mirrored), lattice);
  }
  const auto ends_towards = [&](int to_column, int to_row) {
    return IsBoardEndOnSide(image, lattice, part, to_column, to_row);
  };
  const BoardEnds ends = {ends_towards(-1, 0), ends_towards(0, -1),
                          ends_towards(1, 0), ends_towards(0, 1)};
  right = right_ones(ListNumberings(part, ends, false));
  if (is_unambiguous(right)) return SelectMostUpright(right, lattice);
  *warning = right.empty()
                 ? unlike_board()
                 : fmt::format(
                       "board {}: only {} x {} of its {} x {} "
                       "corners were detected, which may be any part "
                       "of it: it must be visible as a whole, without "
                       "blur, glare or hard shadows",
                       board.id, part.columns(), part.rows(), board.columns,
                       board.rows);
  return std::nullopt;
}

ChessboardLocator::ChessboardLocator(const Board& board)
    : data_(std::make_unique<Data>(board)) {}
ChessboardLocator::~ChessboardLocator() = default;

ImageDetection ChessboardLocator::Locate(const GreyImage& image) const {
  const Board& board = data_->board;
  ImageDetection located;
  std::string in_vain;
  int max_failures = 0;
  const auto is_wanted = [&](const FeatureLattice& seen) {
    const Rectangle part = ComputeReliableRectangle(image, seen);
    std::string warning;
    const auto numbering = data_->AssignNumbers(image, seen, part, &warning);
    if (!numbering) {
      if (seen.num_found() > max_failures) {
        max_failures = seen.num_found();
        in_vain = warning;
      }
      return false;
    }
    FeatureLattice lattice(board);
    for (const Feature& f : seen.Features()) {
      const auto [column, row] = numbering->Of(board, f.column, f.row);
      if (lattice.IsOnBoard(column, row)) lattice.Set(column, row, f.pixel);
    }
    if (warning.empty()) {  // otherwise the image differs from the drawing
      for (const double min_correlation : {0.7, 0.6})
        data_->growth.Grow(image, {min_correlation}, &lattice);
      data_->growth.GrowWithSpacingRatio(image, {0.7, 0.9}, &lattice);
    } else {
      located.warnings.push_back(warning);
    }
    located.features = lattice.Features();
    return true;
  };
  data_->finder.Find(image, is_wanted);
  if (located.features.empty() && !in_vain.empty())
    located.warnings.push_back(in_vain);
  return located;
}

std::optional<ChessboardSize> EstimateChessboardSize(const GreyImage& image) {
  constexpr int kMaxSide = 30, kMinSide = 3;
  constexpr double kMinFilled = 0.95;
  std::optional<ChessboardSize> size;
  ChessLatticeFinder(kMaxSide).Find(image, [&](const FeatureLattice& seen) {
    const Rectangle part = ComputeReliableRectangle(image, seen);
    if (std::min(part.columns(), part.rows()) < kMinSide) return false;
    int num_found = 0;
    for (int row = part.top; row <= part.bottom; ++row)
      for (int column = part.left; column <= part.right; ++column)
        num_found += seen.Has(column, row);
    if (num_found < kMinFilled * part.columns() * part.rows()) return false;
    size = {part.columns(), part.rows()};
    return true;
  });
  return size;
}

Locator MakeChessboardLocator(const Board& board) {
  return [locator = std::make_shared<ChessboardLocator>(board)](
             const GreyImage& image) { return locator->Locate(image); };
}

}  // namespace raygrid
