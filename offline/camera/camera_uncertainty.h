#ifndef RAYGRID_CAMERA_CAMERA_UNCERTAINTY_H
#define RAYGRID_CAMERA_CAMERA_UNCERTAINTY_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/camera_model.h"

namespace raygrid {

/// Standard deviations of a projected coordinate of a far point (RMS of both
/// axes), on a lattice from corner to corner of the camera's area, row by row,
/// with bilinear interpolation. NaN at nodes where the camera is undefined;
/// other pixels are interpolated between the remaining nodes, and are NaN if
/// the nearest node is.
struct UncertaintyLattice {
  int columns = 0, rows = 0;
  std::vector<double> stddev_px;

  double At(const Area& area, const Eigen::Vector2d& pixel) const;
  double MedianPx() const;
  /// Returns the median over the lattice positions within `part`.
  double MedianPx(const Area& area, const Area& part) const;
};

/// Mask of square image cells in the valid region. Pixel (x, y) belongs to cell
/// (floor((x + 1/2) / cell_px), floor((y + 1/2) / cell_px)); pixels on the
/// right and bottom edges belong to the last cells.
struct ValidityMask {
  int knot_spacing_px = 0;  ///< a power of two from 4 to 256
  int columns = 0, rows = 0;
  std::vector<bool> is_valid;  ///< row by row

  /// Returns a mask of invalid cells, each about 1/40 of the longer side.
  static ValidityMask Over(const ImageSize& size);
  /// Returns the number of cells along an image axis.
  static int NumCells(int num_pixels, int knot_spacing_px) {
    return (num_pixels - 1) / knot_spacing_px + 1;
  }

  int CellIndex(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d CellCenter(int cell) const;
  bool IsValidAt(const Eigen::Vector2d& pixel) const {
    return is_valid[CellIndex(pixel)];
  }
  bool HasValidCells() const;
  /// Invalidates the cells with a larger standard deviation. `lattice` covers
  /// `area`; outside the area, its nearest value is used.
  void InvalidateAbove(double max_stddev_px, const UncertaintyLattice& lattice,
                       const Area& area);
};

/// Standard deviations of displacements of an unchanged camera in addition to
/// its error modes: relative scale, shift, tilt of the sensor about its
/// vertical and horizontal axes, and local displacement, per axis.
struct MovementErrors {
  double scale = 0, shift_px = 0, tilt_rad = 0, local_px = 0;

  bool HasSmooth() const { return scale > 0 || shift_px > 0 || tilt_rad > 0; }
};

/// Correlated errors of a camera: the error is approximately a sum of
/// displacement fields, each multiplied by an independent standard normal
/// variable. On a lattice from corner to corner of the area, row by row, with
/// bilinear interpolation.
struct ErrorModes {
  int columns = 0, rows = 0;
  std::vector<std::vector<Eigen::Vector2d>> displacements_px;
  double residual_px = 0;        ///< 1 σ of the residual error, per axis
  MovementErrors excess_errors;  ///< additional errors in held-out images

  Eigen::Vector2d At(size_t mode, const Area& area,
                     const Eigen::Vector2d& pixel) const;
};

/// Uncertainty of a camera: due to noise in the valid region, and to all
/// sources of uncertainty elsewhere.
struct CameraUncertainty {
  UncertaintyLattice lattice;
  ValidityMask mask;
  double max_stddev_px = 0;  ///< maximum over the valid cells
  ErrorModes modes;          ///< may be empty
  /// Not stored in files: standard deviation between cameras calibrated from
  /// other images of the same number, RMS of both axes.
  UncertaintyLattice scatter;
  /// Ratio of jackknife standard deviations to the prediction for white noise:
  /// median over pixels near features.
  double jackknife_scale = 1;

  /// Returns an uncertainty with a mask but without standard deviations.
  static CameraUncertainty FromMask(const ValidityMask& mask);
  bool HasStdDevs() const;

  /// Returns the fraction of the image's pixels in the valid region.
  double ValidFraction(const ImageSize& size, const Area& area) const;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_UNCERTAINTY_H
