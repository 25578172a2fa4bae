#ifndef RAYGRID_PACKING_INVERSE_GRID_H
#define RAYGRID_PACKING_INVERSE_GRID_H

#include <optional>

#include "camera/bspline_surface.h"
#include "camera/camera_uncertainty.h"
#include "packing/narrow_grid.h"
#include "rg_blob.h"

namespace raygrid {

/// An inverse grid's section and its control points.
struct InverseGrid {
  rg_inverse_section section = {};
  NarrowGrid points;
};

/// Where a surface over the image reaches each chart position: the
/// least-squares spline through a few thousand samples, with as few cells as
/// bring projection to its end in one step. Pixels that are not trusted, or
/// where the surface is folded, do not count; nullptr trusts all. Nothing if 16
/// bits do not hold it.
std::optional<InverseGrid> MakeInverseGrid(const BSplineSurface& surface,
                                           const TrustMask* trusted);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_INVERSE_GRID_H
