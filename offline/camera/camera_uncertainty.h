#ifndef RAYGRID_CAMERA_CAMERA_UNCERTAINTY_H
#define RAYGRID_CAMERA_CAMERA_UNCERTAINTY_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/camera_model.h"

namespace raygrid {

/// Standard deviations of a coordinate of the projection of a far point, the
/// RMS of both axes: on a lattice from corner to corner of the camera's area,
/// row by row, bilinear between. NaN where the camera is undefined.
struct UncertaintyLattice {
  int columns = 0, rows = 0;
  std::vector<double> deviation_px;

  double At(const Area& area, const Eigen::Vector2d& pixel) const;
  double MedianPx() const;
  /// The median over the lattice's places within a part of the area.
  double MedianPx(const Area& area, const Area& part) const;
};

/// Which square cells of the image a camera can be trusted in. Pixel (x, y) is
/// in cell (floor((x + 1/2) / cell_px), floor((y + 1/2) / cell_px)), pixels on
/// the image's far edges in the last ones.
struct ValidityMask {
  int knot_spacing_px = 0;  ///< a power of two from 4 to 256
  int columns = 0, rows = 0;
  std::vector<bool> is_trusted;  ///< row by row

  /// A mask with cells about a fortieth of the longer side, none trusted.
  static ValidityMask Over(const ImageSize& size);
  /// Cells of an image's rows and columns.
  static int NumCells(int num_pixels, int knot_spacing_px) {
    return (num_pixels - 1) / knot_spacing_px + 1;
  }

  int CellIndex(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d CellCenter(int cell) const;
  bool IsValidAt(const Eigen::Vector2d& pixel) const {
    return is_trusted[CellIndex(pixel)];
  }
  bool HasValidCells() const;
  /// Trusts no cell any more in which a deviation is larger. The deviations are
  /// those over the area; beyond it, the nearest ones of it count.
  void InvalidateAbove(double max_deviation_px,
                       const UncertaintyLattice& lattice, const Area& area);
};

/// Standard deviations of what moves the images of an unchanged camera beyond
/// its modes: the part by which they grow, shifts, turns of the sensor about
/// its vertical and horizontal axes, and local displacements, in an axis each.
struct MovementErrors {
  double scale = 0, shift_px = 0, tilt_rad = 0, local_px = 0;

  bool HasSmooth() const { return scale > 0 || shift_px > 0 || tilt_rad > 0; }
};

/// How errors of a camera in one place go with those in others: its error is
/// about a sum of these displacements, each times a standard normal number of
/// its own. On a lattice from corner to corner of the area, row by row,
/// bilinear between.
struct ErrorModes {
  int columns = 0, rows = 0;
  std::vector<std::vector<Eigen::Vector2d>> displacements_px;
  double rest_px = 0;     ///< standard deviation of what they leave, in an axis
  MovementErrors beyond;  ///< as seen in images that did not calibrate it

  Eigen::Vector2d At(size_t mode, const Area& area,
                     const Eigen::Vector2d& pixel) const;
};

/// How well a camera is known: by the calibration's noise where it can be
/// trusted, by all that is not known elsewhere.
struct CameraUncertainty {
  UncertaintyLattice lattice;
  ValidityMask mask;
  double max_deviation_px = 0;  ///< of the cells trusted
  ErrorModes modes;             ///< may be empty
  /// Of a calibration that is not from a file: the standard deviation between
  /// cameras of as many other images, the RMS of both axes.
  UncertaintyLattice scatter;
  /// Standard deviations, as a multiple of those that white noise predicts: the
  /// median of the pixels near features.
  double jackknife_scale = 1;

  /// How well a camera is known of which no deviation is.
  static CameraUncertainty FromMask(const ValidityMask& mask);
  bool HasDeviations() const;

  /// The part of the image's pixels that is trusted.
  double ValidFraction(const ImageSize& size, const Area& area) const;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_UNCERTAINTY_H
