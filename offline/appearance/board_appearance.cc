#include "appearance/board_appearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"

namespace raygrid {
namespace {

// Returns the code cells within the black border, which is one cell wide for
// all tags and markers.
MarkerBits CodeBits(const MarkerBits& all, bool is_april_tag) {
  // Bitmaps of AprilTags include a white margin of one cell.
  const int around = is_april_tag ? 2 : 1;
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

// Returns the cells of a marker. Markers with a separate border width have no
// white margin.
MarkerBits GetMarkerBits(const MarkerPosition& place) {
  const MarkerBits bits = place.is_april_tag
                              ? AprilTagBits(place.family, place.id)
                              : ArucoBits(place.family, place.id);
  if (place.border_cells == 0) return bits;
  return WithBorder(CodeBits(bits, place.is_april_tag), place.border_cells);
}

// Adds rectangles for runs of adjacent black cells of each row.
void AddCells(const PlacedMarker& marker, InkLayer* layer) {
  for (int row = 0; row < marker.bits.size; ++row) {
    for (int column = 0; column < marker.bits.size; ++column) {
      if (!marker.bits.at(column, row)) continue;
      const int first = column;
      while (column + 1 < marker.bits.size && marker.bits.at(column + 1, row))
        ++column;
      const Eigen::Vector2d& c = marker.corner;
      layer->polygons.push_back(RectanglePolygon(
          c.x() + first * marker.cell_m, c.y() + row * marker.cell_m,
          c.x() + (column + 1) * marker.cell_m,
          c.y() + (row + 1) * marker.cell_m));
    }
  }
}

}  // namespace

BoardAppearance::BoardAppearance(const Board& board)
    : board_(board), kind_(&KindOf(board)), extent_m_(kind_->Extent(board)) {
  if (!kind_->is_drawable)
    throw InputError(
        fmt::format("board {}: cannot draw a target of kind '{}'; use {}",
                    board.id, board.kind, DrawableKinds()));
  for (const MarkerPosition& place : kind_->Markers(board)) {
    PlacedMarker& marker = markers_.emplace_back();
    marker.id = place.id;
    marker.bits = GetMarkerBits(place);
    marker.corner = place.corner;
    marker.cell_m = place.side_m / marker.bits.size;
  }
}

bool BoardAppearance::IsBlack(const Eigen::Vector2d& point_m) const {
  if (!extent_m_.Contains(point_m)) return false;
  for (const PlacedMarker& marker : markers_) {
    const Eigen::Vector2d cell = (point_m - marker.corner) / marker.cell_m;
    if (cell.minCoeff() < 0 || cell.maxCoeff() >= marker.bits.size) continue;
    return marker.bits.at(static_cast<int>(cell.x()),
                          static_cast<int>(cell.y()));
  }
  return kind_->IsBlack(board_, point_m.x() / board_.square_m,
                        point_m.y() / board_.square_m);
}

std::vector<InkLayer> BoardAppearance::Layers() const {
  InkLayer ink, paper, cells;
  paper.is_black = false;
  ink.polygons = kind_->Ink(board_);
  for (const PlacedMarker& marker : markers_) {
    const Eigen::Vector2d& c = marker.corner;
    const double side = marker.side_m();
    paper.polygons.push_back(
        RectanglePolygon(c.x(), c.y(), c.x() + side, c.y() + side));
    AddCells(marker, &cells);
  }
  return {ink, paper, cells};
}

}  // namespace raygrid
