#ifndef RAYGRID_PACKING_BLOB_GRID_H
#define RAYGRID_PACKING_BLOB_GRID_H

#include <cstdint>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "packing/narrow_grid.h"
#include "rg_blob.h"

namespace raygrid {

/// The grid that stands for a central camera in a blob: its own, or the
/// coarsest that follows it to half of kMaxPackingErrorPx where it is trusted,
/// or everywhere without a mask. Control points that the format cannot hold are
/// drawn back to it where no trusted pixel sees by them, as in the corners
/// around a fisheye's image circle. Throws Error(kQuality) if no grid follows
/// the camera, or the format cannot hold it.
CentralGeneric MakeBlobGrid(const CameraModel& camera,
                            const TrustMask* trusted);

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
