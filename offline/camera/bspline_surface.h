#ifndef RAYGRID_CAMERA_BSPLINE_SURFACE_H
#define RAYGRID_CAMERA_BSPLINE_SURFACE_H

#include <Eigen/Core>
#include <array>
#include <vector>

#include "camera/area.h"
#include "camera/pixel_search.h"

namespace raygrid {

/// The 16 control points around a position and their weights there.
struct SplineSupport {
  int column = 0, row = 0;         ///< of the top-left one
  std::array<double, 4> wx, wy;    ///< sum to 1
  std::array<double, 4> dwx, dwy;  ///< their derivatives per pixel
};

/// Uniform cubic B-spline surface over an area of the image, with values in the
/// plane (paper, "Camera Model"). The area is cut into (columns - 3) x
/// (rows - 3) equal cells; one ring of control points lies outside.
class BSplineSurface {
 public:
  BSplineSurface() = default;
  /// All control points zero. columns, rows >= 4.
  BSplineSurface(const Area& area, int columns, int rows);

  const Area& area() const { return area_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int num_points() const { return columns_ * rows_; }
  double cell_width() const { return area_.width() / (columns_ - 3); }
  double cell_height() const { return area_.height() / (rows_ - 3); }

  /// Row-major.
  const std::vector<Eigen::Vector2d>& points() const { return points_; }
  std::vector<Eigen::Vector2d>& points() { return points_; }

  /// The place of a control point in the image; the outermost ring lies outside
  /// the area.
  Eigen::Vector2d GetPixel(int index) const {
    return {area_.x0 + (index % columns_ - 1) * cell_width(),
            area_.y0 + (index / columns_ - 1) * cell_height()};
  }

  /// Pixels at equal distances, per_cell^2 in each cell, up to the edges.
  std::vector<Eigen::Vector2d> SamplePixels(int per_cell) const;

  /// Beyond the area, the border cell's polynomial goes on.
  SplineSupport Support(const Eigen::Vector2d& pixel) const;

  Eigen::Vector2d Evaluate(const Eigen::Vector2d& pixel) const;

  /// Value and, in *derivative, its derivative by the pixel.
  Eigen::Vector2d Evaluate(const Eigen::Vector2d& pixel,
                           Eigen::Matrix2d* derivative) const;

 private:
  Area area_;
  int columns_ = 0, rows_ = 0;
  std::vector<Eigen::Vector2d> points_;
};

/// +1 or -1, the sign of the derivative's determinant in most of the area's
/// middle, half as wide and half as high. It is the other one where the surface
/// is folded, as a grid may be beyond a fisheye's image circle.
int FindDominantHandedness(const BSplineSurface& surface);

/// The side of most of the middle; no side where no control point is folded.
UnfoldedSide FindUnfoldedSide(const BSplineSurface& surface);

/// The number of control points along an extent for cells no longer than
/// cell_px.
int NumControlPoints(double extent_px, double knot_spacing_px);

/// A measured value of a surface.
struct SurfaceSample {
  Eigen::Vector2d pixel;
  Eigen::Vector2d value;
  double weight = 1;  ///< of its squared error
};

/// Least-squares surface through samples; where there are none, as smooth as
/// possible: the squares of second differences count with weight smoothness,
/// which samples are to outvote.
BSplineSurface FitSurface(const Area& area, int columns, int rows,
                          const std::vector<SurfaceSample>& samples,
                          double smoothness = 1e-9);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_BSPLINE_SURFACE_H
