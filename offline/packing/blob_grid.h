#ifndef RAYGRID_PACKING_BLOB_GRID_H
#define RAYGRID_PACKING_BLOB_GRID_H

#include <cstdint>
#include <optional>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "packing/narrow_grid.h"
#include "packing/regular_region.h"
#include "rg_blob.h"

namespace raygrid {

/// The grid that stands for a central camera in a blob, and where it does.
struct BlobGrid {
  CentralGeneric grid;
  /// The trusted cells but those that are not regular all over, and those in
  /// which the grid does not follow the camera; nothing if that is all of them.
  std::optional<TrustMask> valid;
  /// Whether the grid follows the camera in all of its regular region.
  bool follows_all = true;
};

/// The grid that stands for a central camera in a blob: its own, or the
/// coarsest of up to 128 cells that follows it to half of a bound in its
/// regular region, of the cells that are trusted if there is a mask; or else,
/// of up to 256 cells, one that leaves out about the least of it. Control
/// points that the format cannot hold are drawn back to it. The region is that
/// of the camera, or NULL for a grid that the format holds as it is. Throws
/// Error(kQuality) if no grid follows the camera anywhere.
BlobGrid MakeBlobGrid(const CameraModel& camera, const RegularRegion* region,
                      const TrustMask* trusted, double max_error_px);

/// Whether the format holds a camera as it is: a grid over an area of whole
/// 1/65536 px, all of whose control points are within the chart's reach.
bool IsBlobGrid(const CameraModel& camera);

/// A grid in the format's integers: area and scale, control points in q29.
struct GridSection {
  rg_grid_section section = {};
  ControlPoints control_points;
};

/// Throws Error(kQuality) for cells of a pixel or less.
GridSection QuantizeGrid(const CentralGeneric& camera);

/// The points of a camera's lines in q28 metres, x, y, z for each control point
/// of the grid; fitted anew if the grid is not the camera's own. Throws
/// Error(kQuality) for points that the format cannot hold.
std::vector<int32_t> QuantizeLinePoints(const NonCentralGeneric& camera,
                                        const BSplineSurface& grid);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_BLOB_GRID_H
