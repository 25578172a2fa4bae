#include "appearance/board_appearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"

namespace raygrid {
namespace {

Polygon Rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

// The part of a convex polygon where sign * (p[axis] - bound) <= 0.
Polygon ClippedAt(const Polygon& polygon, int axis, double sign, double bound) {
  Polygon clipped;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - bound), db = sign * (b[axis] - bound);
    if (da <= 0) clipped.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0))
      clipped.push_back(a + (b - a) * (da / (da - db)));
  }
  return clipped;
}

Polygon Clipped(Polygon polygon, const Area& area) {
  polygon = ClippedAt(polygon, 0, -1, area.x0);
  polygon = ClippedAt(polygon, 0, 1, area.x1);
  polygon = ClippedAt(polygon, 1, -1, area.y0);
  return ClippedAt(polygon, 1, 1, area.y1);
}

// The point where the ray at an angle, counter-clockwise from up, leaves the
// square of half width 1.
Eigen::Vector2d OnSquare(double angle) {
  const Eigen::Vector2d direction(-std::sin(angle), -std::cos(angle));
  return direction / direction.cwiseAbs().maxCoeff();
}

// A segment of a star in a square of half width 1.
Polygon Segment(int segments, int k) {
  const double begin = 2 * M_PI * k / segments;
  const double end = 2 * M_PI * (k + 1) / segments;
  Polygon polygon = {{0, 0}, OnSquare(begin)};
  for (double corner = M_PI / 4; corner < 2 * M_PI; corner += M_PI / 2)
    if (corner > begin + 1e-9 && corner < end - 1e-9)
      polygon.push_back(OnSquare(corner));
  polygon.push_back(OnSquare(end));
  return polygon;
}

std::vector<PlacedMarker> StarTags(const Board& board) {
  std::vector<PlacedMarker> markers;
  for (const BoardTag& tag : board.tags) {
    PlacedMarker marker;
    marker.id = tag.id;
    marker.bits = AprilTagBits(tag.family, tag.id);
    marker.corner = Eigen::Vector2d(tag.column, tag.row) * board.square_m;
    marker.cell_m = tag.squares * board.square_m / marker.bits.size;
    markers.push_back(marker);
  }
  return markers;
}

// The squares' corner (0, 0) lies one square left of and above feature (0, 0).
std::vector<PlacedMarker> CharucoMarkers(const Board& board) {
  std::vector<PlacedMarker> markers;
  const double margin_m = (board.square_m - board.marker_m) / 2;
  int id = board.first_marker;
  for (int row = 0; row <= board.rows; ++row) {
    const int counted_row = board.is_legacy ? board.rows - row : row;
    for (int column = 0; column <= board.columns; ++column) {
      if (counted_row % 2 == column % 2) continue;
      PlacedMarker marker;
      marker.id = id++;
      marker.bits = ArucoBits(board.dictionary, marker.id);
      marker.corner = Eigen::Vector2d((column - 1) * board.square_m + margin_m,
                                      (row - 1) * board.square_m + margin_m);
      marker.cell_m = board.marker_m / marker.bits.size;
      markers.push_back(marker);
    }
  }
  return markers;
}

// The cells of a tag within its black border, which all tags and markers have
// one cell wide.
MarkerBits CodeBits(const std::string& family, int id) {
  const bool is_april_tag = family.compare(0, 3, "tag") == 0;
  // AprilTags come with a white margin of one cell.
  const int around = is_april_tag ? 2 : 1;
  const MarkerBits all =
      is_april_tag ? AprilTagBits(family, id) : ArucoBits(family, id);
  MarkerBits code;
  code.size = all.size - 2 * around;
  for (int row = 0; row < code.size; ++row)
    for (int column = 0; column < code.size; ++column)
      code.is_black.push_back(all.at(column + around, row + around));
  return code;
}

MarkerBits WithBorder(const MarkerBits& code, int border_cells) {
  MarkerBits bits;
  bits.size = code.size + 2 * border_cells;
  bits.is_black.assign(bits.size * bits.size, true);
  for (int row = 0; row < code.size; ++row)
    for (int column = 0; column < code.size; ++column)
      bits.is_black[(row + border_cells) * bits.size + column + border_cells] =
          code.at(column, row);
  return bits;
}

std::vector<PlacedMarker> AprilGridTags(const Board& board) {
  std::vector<PlacedMarker> markers;
  const int columns = board.columns / 2, rows = board.rows / 2;
  const double pitch_m = board.square_m * (1 + board.spacing_ratio);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      PlacedMarker marker;
      const int counted_row = board.is_numbered_from_top ? row : rows - 1 - row;
      marker.id = board.first_marker + counted_row * columns + column;
      marker.bits =
          WithBorder(CodeBits(board.tag_family, marker.id), board.border_cells);
      marker.corner = Eigen::Vector2d(column, row) * pitch_m;
      marker.cell_m = board.square_m / marker.bits.size;
      markers.push_back(marker);
    }
  }
  return markers;
}

// Black cells of a row that touch are one rectangle.
void AddCells(const PlacedMarker& marker, InkLayer* layer) {
  for (int row = 0; row < marker.bits.size; ++row) {
    for (int column = 0; column < marker.bits.size; ++column) {
      if (!marker.bits.at(column, row)) continue;
      const int first = column;
      while (column + 1 < marker.bits.size && marker.bits.at(column + 1, row))
        ++column;
      const Eigen::Vector2d& c = marker.corner;
      layer->polygons.push_back(Rectangle(c.x() + first * marker.cell_m,
                                          c.y() + row * marker.cell_m,
                                          c.x() + (column + 1) * marker.cell_m,
                                          c.y() + (row + 1) * marker.cell_m));
    }
  }
}

bool IsOdd(int value) { return value % 2 != 0; }

}  // namespace

bool IsBlackInStar(int segments, double right, double down) {
  const double turns = std::atan2(-right, -down) / (2 * M_PI);
  const int k = static_cast<int>(std::floor(turns * segments));
  return !IsOdd(k);  // segments is even: negative k need no wrap
}

BoardAppearance::BoardAppearance(const Board& board) : board_(board) {
  const double s = board.square_m;
  if (board.kind == "star") {
    markers_ = StarTags(board);
  } else if (board.kind == "charuco") {
    markers_ = CharucoMarkers(board);
  } else if (board.kind == "aprilgrid") {
    markers_ = AprilGridTags(board);
  } else if (board.kind != "chessboard") {
    throw InputError(
        fmt::format("board {}: cannot draw a target of kind '{}'; use star, "
                    "chessboard, charuco or aprilgrid",
                    board.id, board.kind));
  }
  if (board.kind == "aprilgrid") {
    const double gap = s * board.spacing_ratio;
    const double pitch = s + gap;
    extent_m_ = {-gap, -gap, board.columns / 2 * pitch, board.rows / 2 * pitch};
    if (!board.has_corner_squares)
      extent_m_ = {0, 0, extent_m_.x1 - gap, extent_m_.y1 - gap};
  } else {
    extent_m_ = {-s, -s, board.columns * s, board.rows * s};
  }
}

bool BoardAppearance::IsBlackBesideMarkers(const Eigen::Vector2d& p) const {
  const double x = p.x() / board_.square_m, y = p.y() / board_.square_m;
  if (board_.kind == "star")
    return IsBlackInStar(board_.segments, x - std::round(x), y - std::round(y));
  if (board_.kind == "aprilgrid") {
    // Black squares fill the crossings of the gaps between tags.
    const double pitch = 1 + board_.spacing_ratio;
    return board_.has_corner_squares &&
           x - std::floor(x / pitch) * pitch >= 1 &&
           y - std::floor(y / pitch) * pitch >= 1;
  }
  const int column = static_cast<int>(std::floor(x)) + 1;
  int row = static_cast<int>(std::floor(y)) + 1;
  if (board_.is_legacy) row = board_.rows - row;
  return IsOdd(row) == IsOdd(column);
}

bool BoardAppearance::IsBlack(const Eigen::Vector2d& point_m) const {
  if (!extent_m_.Contains(point_m)) return false;
  for (const PlacedMarker& marker : markers_) {
    const Eigen::Vector2d cell = (point_m - marker.corner) / marker.cell_m;
    if (cell.minCoeff() < 0 || cell.maxCoeff() >= marker.bits.size) continue;
    return marker.bits.at(static_cast<int>(cell.x()),
                          static_cast<int>(cell.y()));
  }
  return IsBlackBesideMarkers(point_m);
}

void BoardAppearance::AddStars(InkLayer* layer) const {
  const double s = board_.square_m;
  for (int row = -1; row <= board_.rows; ++row) {
    for (int column = -1; column <= board_.columns; ++column) {
      for (int k = 0; k < board_.segments; k += 2) {
        Polygon polygon = Segment(board_.segments, k);
        for (Eigen::Vector2d& p : polygon)
          p = Eigen::Vector2d((column + p.x() / 2) * s, (row + p.y() / 2) * s);
        polygon = Clipped(std::move(polygon), extent_m_);
        if (polygon.size() > 2) layer->polygons.push_back(std::move(polygon));
      }
    }
  }
}

void BoardAppearance::AddSquares(InkLayer* layer) const {
  const double s = board_.square_m;
  for (int row = 0; row <= board_.rows; ++row) {
    const int counted_row = board_.is_legacy ? board_.rows - row : row;
    for (int column = 0; column <= board_.columns; ++column)
      if (counted_row % 2 == column % 2)
        layer->polygons.push_back(
            Rectangle((column - 1) * s, (row - 1) * s, column * s, row * s));
  }
}

void BoardAppearance::AddCornerSquares(InkLayer* layer) const {
  const double gap = board_.square_m * board_.spacing_ratio;
  const double pitch = board_.square_m + gap;
  for (int row = 0; row <= board_.rows / 2; ++row)
    for (int column = 0; column <= board_.columns / 2; ++column)
      layer->polygons.push_back(Rectangle(column * pitch - gap,
                                          row * pitch - gap, column * pitch,
                                          row * pitch));
}

std::vector<InkLayer> BoardAppearance::Layers() const {
  InkLayer ink, paper, cells;
  paper.is_black = false;
  if (board_.kind == "star") {
    AddStars(&ink);
  } else if (board_.kind == "aprilgrid") {
    if (board_.has_corner_squares) AddCornerSquares(&ink);
  } else {
    AddSquares(&ink);
  }
  for (const PlacedMarker& marker : markers_) {
    const Eigen::Vector2d& c = marker.corner;
    const double side = marker.side_m();
    paper.polygons.push_back(
        Rectangle(c.x(), c.y(), c.x() + side, c.y() + side));
    AddCells(marker, &cells);
  }
  return {ink, paper, cells};
}

}  // namespace raygrid
