#ifndef RAYGRID_EVALUATION_OPERATING_POINT_CHANGE_H
#define RAYGRID_EVALUATION_OPERATING_POINT_CHANGE_H

#include <Eigen/Core>
#include <vector>

#include "camera/operating_point_model.h"

namespace raygrid {

/// The change of a distant scene's image between the mid-range and another
/// operating point, for models with one variable.
struct OperatingPointChange {
  double value = 0;
  double focal_px = 0;  ///< at the area's centre
  double growth = 0;    ///< 0.01: the image is 1 % larger
  /// Principal point of the best-fitting model with radial distortion, whose
  /// axis may differ from z.
  Eigen::Vector2d center_px;
  double distortion_px = 0;  ///< RMS after removing scale and shift
};

/// Computes the changes at evenly spaced values over the range.
std::vector<OperatingPointChange> MeasureOperatingPointChanges(
    const OperatingPointModel& stack, int num_values);

/// Returns the centres of the cells of an area, row by row.
std::vector<Eigen::Vector2d> SampleCellCenters(const Area& area, int columns,
                                               int rows);

/// Computes the displacements (px) of distant points between two operating
/// points, after removing the scale and shift that explain most of them; NaN
/// where either camera is undefined.
std::vector<Eigen::Vector2d> MeasureDistortion(
    const CentralGeneric& from, const CentralGeneric& to,
    const std::vector<Eigen::Vector2d>& pixels);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_OPERATING_POINT_CHANGE_H
