#ifndef RAYGRID_CAMERA_BSPLINE_SURFACE_H
#define RAYGRID_CAMERA_BSPLINE_SURFACE_H

#include <Eigen/Core>
#include <array>
#include <vector>

#include "camera/area.h"
#include "camera/pixel_search.h"

namespace raygrid {

/// The 16 control points around a position, and their weights there.
struct SplineSupport {
  int column = 0, row = 0;         ///< indices of the top-left one
  std::array<double, 4> wx, wy;    ///< sum to 1
  std::array<double, 4> dwx, dwy;  ///< derivatives of wx, wy per pixel
};

/// Uniform cubic B-spline surface over an area of the image, with values in the
/// plane (paper, "Camera Model"). The area is divided into (columns - 3) x
/// (rows - 3) equal cells; one ring of control points lies outside.
class BSplineSurface {
 public:
  BSplineSurface() = default;
  /// Sets all control points to zero. columns, rows >= 4.
  BSplineSurface(const Area& area, int columns, int rows);

  const Area& area() const { return area_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int num_points() const { return columns_ * rows_; }
  double cell_width() const { return area_.width() / (columns_ - 3); }
  double cell_height() const { return area_.height() / (rows_ - 3); }

  /// The control points, row by row.
  const std::vector<Eigen::Vector2d>& points() const { return points_; }
  std::vector<Eigen::Vector2d>& points() { return points_; }

  /// Returns the position of a control point in the image; the outermost ring
  /// lies outside the area.
  Eigen::Vector2d GetPixel(int index) const {
    return {area_.x0 + (index % columns_ - 1) * cell_width(),
            area_.y0 + (index / columns_ - 1) * cell_height()};
  }

  /// Samples each cell of the area at per_cell x per_cell pixels, including the
  /// edges of the area.
  std::vector<Eigen::Vector2d> SamplePixels(int per_cell) const;

  /// Extrapolates the polynomial of the border cell outside the area.
  SplineSupport Support(const Eigen::Vector2d& pixel) const;

  Eigen::Vector2d Evaluate(const Eigen::Vector2d& pixel) const;

  /// Returns the value. *derivative receives its Jacobian with respect to the
  /// pixel.
  Eigen::Vector2d Evaluate(const Eigen::Vector2d& pixel,
                           Eigen::Matrix2d* derivative) const;

 private:
  Area area_;
  int columns_ = 0, rows_ = 0;
  std::vector<Eigen::Vector2d> points_;
};

/// Returns +1 or -1: the predominant sign of the Jacobian's determinant in the
/// central half of the area's width and height. The sign differs where the
/// surface is folded, which may happen outside a fisheye's image circle.
int ComputeDominantHandedness(const BSplineSurface& surface);

/// Returns the unfolded side, which has the dominant handedness; handedness 0
/// if no control point is folded.
UnfoldedSide ComputeUnfoldedSide(const BSplineSurface& surface);

/// Returns the number of control points along an extent for cells no longer
/// than knot_spacing_px.
int NumControlPoints(double extent_px, double knot_spacing_px);

/// A sample of a surface for fitting.
struct SurfaceSample {
  Eigen::Vector2d pixel;
  Eigen::Vector2d value;
  double weight = 1;  ///< weight of squared error
};

/// Fits a surface to samples by least squares; without samples nearby, the
/// surface is as smooth as possible: squared second differences are added with
/// the small weight `smoothness`.
BSplineSurface FitSurface(const Area& area, int columns, int rows,
                          const std::vector<SurfaceSample>& samples,
                          double smoothness = 1e-9);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_BSPLINE_SURFACE_H
