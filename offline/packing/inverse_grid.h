#ifndef RAYGRID_PACKING_INVERSE_GRID_H
#define RAYGRID_PACKING_INVERSE_GRID_H

#include <functional>
#include <optional>
#include <vector>

#include "camera/bspline_surface.h"
#include "camera/camera_uncertainty.h"
#include "packing/narrow_grid.h"
#include "packing/projection_error.h"
#include "rg_blob.h"

namespace raygrid {

/// An inverse grid's section and its control points.
struct InverseGrid {
  rg_inverse_section section = {};
  NarrowGrid points;
};

/// Measures the runtime's projection with an inverse grid, by about so many
/// pixels; nothing if the format does not hold the grid.
using MeasureInverse = std::function<std::optional<ProjectionError>(
    const InverseGrid&, double max_pixels)>;

struct MeasuredInverse {
  InverseGrid grid;
  ProjectionError error;
  bool is_close = false;  ///< one step is right everywhere
};

/// The inverse of a surface over the image, with a pixel for each chart
/// position: the least-squares spline through samples of the whole area but
/// where it is folded, with as few cells as let the runtime find all trusted
/// pixels again, and up to 24 cells if that brings it there in one step or
/// finds more of the others. If trusted pixels are lost even so, the spline
/// through samples of their surroundings alone, or else the one that loses
/// fewest. nullptr trusts all. Nothing if no trusted pixel can be found by one.
std::optional<MeasuredInverse> FitInverseGrid(const BSplineSurface& surface,
                                              const TrustMask* trusted,
                                              const MeasureInverse& measure);

/// Measures the runtime's projection with the inverse grid of one of several
/// surfaces; otherwise as MeasureInverse.
using MeasureOneInverse = std::function<std::optional<ProjectionError>(
    size_t surface, const InverseGrid&, double max_pixels)>;

/// The inverses of the surfaces of one camera at several conditions, alike but
/// for their control points: over a rectangle and a cone that do for all, with
/// as few cells, up to 24, as let the runtime find all trusted pixels of each
/// surface in one step, or else with those that lose fewest. Nothing if 16 bits
/// hold none.
std::optional<std::vector<MeasuredInverse>> FitAlikeInverseGrids(
    const std::vector<const BSplineSurface*>& surfaces,
    const TrustMask* trusted, const MeasureOneInverse& measure);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_INVERSE_GRID_H
