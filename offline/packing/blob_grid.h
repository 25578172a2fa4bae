#ifndef RAYGRID_PACKING_BLOB_GRID_H
#define RAYGRID_PACKING_BLOB_GRID_H

#include <cstdint>
#include <optional>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "packing/int16_grid.h"
#include "packing/regular_region.h"
#include "rg_blob.h"

namespace raygrid {

/// The grid that approximates a central camera in a blob, and its valid cells.
struct BlobGrid {
  CentralGeneric grid;
  /// The valid cells: excludes cells that are not completely regular, and cells
  /// in which the grid's error exceeds the bound. nullopt if no cell is
  /// excluded.
  std::optional<ValidityMask> valid;
  /// Whether the fit error is within the bound in the whole regular region.
  bool is_reproduced_everywhere = true;
};

/// Makes the grid that approximates a central camera in a blob: the camera's
/// own grid, or the coarsest of up to 128 cells with a fit error of at most
/// half the bound in its regular region, restricted to the valid region if
/// there is a mask; otherwise, a grid of up to 256 cells that excludes nearly
/// the minimum number of pixels. Control points outside the format's range are
/// moved into it. region: the camera's, or NULL for a grid that the format
/// represents exactly. Throws Error(kQualityTooLow) if no grid fits the camera
/// anywhere.
BlobGrid MakeBlobGrid(const CameraModel& camera, const RegularRegion* region,
                      const ValidityMask* valid_region, double max_error_px);

/// Returns whether the format represents a camera exactly, without a fit: a
/// grid whose area is in whole 1/65536 px, with all control points within the
/// range of the chart.
bool IsBlobGrid(const CameraModel& camera);

/// A grid in the integers of the format: area and scale, control points in q29.
struct GridSection {
  rg_grid_section section = {};
  ControlPoints control_points;
};

/// Quantizes a grid. Throws Error(kQualityTooLow) for a knot spacing below 1
/// px.
GridSection QuantizeGrid(const CentralGeneric& camera);

/// Returns the points of the observation lines in q28 metres, x, y, z for each
/// control point; fitted if `grid` is not the camera's own grid. Throws
/// Error(kQualityTooLow) for points outside the format's range.
std::vector<int32_t> QuantizeLinePoints(const NonCentralGeneric& camera,
                                        const BSplineSurface& grid);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_BLOB_GRID_H
