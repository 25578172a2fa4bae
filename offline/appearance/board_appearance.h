/// The appearance of a board, i.e. its printed areas, from which the printed
/// page, the rendered image and the template for matching are made.
#ifndef RAYGRID_APPEARANCE_BOARD_APPEARANCE_H
#define RAYGRID_APPEARANCE_BOARD_APPEARANCE_H

#include <Eigen/Core>
#include <vector>

#include "appearance/marker_bits.h"
#include "camera/area.h"
#include "dataset/kinds/target_kind.h"

namespace raygrid {

/// Polygons of one colour that do not overlap; layers are painted in order.
struct InkLayer {
  bool is_black = true;
  std::vector<Polygon> polygons;
};

/// A marker on a board: bits.size x bits.size cells, the first at corner.
struct PlacedMarker {
  int id = 0;
  Eigen::Vector2d corner;  ///< position of the outermost cell, m
  double cell_m = 0;
  MarkerBits bits;

  double side_m() const { return bits.size * cell_m; }
};

/// Printed areas of a board on white paper, in the board's plane: metres, x
/// along the columns, y down the rows, feature (0, 0) of star boards,
/// chessboards and AprilGrids at the origin.
///
/// Stars (paper, "Calibration Pattern"): the star at each lattice point fills a
/// square, clipped to the rectangle one square beyond the outermost features.
/// Segment k spans the angles 2 pi k / n to 2 pi (k + 1) / n, counter-clockwise
/// from up as seen on the page; even segments are black.
class BoardAppearance {
 public:
  /// Throws InputError for kinds that cannot be drawn, and for unknown
  /// dictionaries and markers.
  explicit BoardAppearance(const Board& board);

  /// Returns the bounding rectangle of all ink; the paper around it is white.
  const Area& extent_m() const { return extent_m_; }
  const std::vector<PlacedMarker>& markers() const { return markers_; }

  bool IsBlack(const Eigen::Vector2d& point_m) const;

  std::vector<InkLayer> Layers() const;

 private:
  Board board_;
  const TargetKind* kind_;
  Area extent_m_;
  std::vector<PlacedMarker> markers_;
};

}  // namespace raygrid

#endif  // RAYGRID_APPEARANCE_BOARD_APPEARANCE_H
