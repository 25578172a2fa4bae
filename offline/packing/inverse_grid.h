#ifndef RAYGRID_PACKING_INVERSE_GRID_H
#define RAYGRID_PACKING_INVERSE_GRID_H

#include <functional>
#include <optional>
#include <vector>

#include "camera/bspline_surface.h"
#include "camera/camera_uncertainty.h"
#include "packing/int16_grid.h"
#include "packing/projection_error.h"
#include "rg_blob.h"

namespace raygrid {

/// An inverse grid's section and its control points.
struct InverseGrid {
  rg_inverse_section section = {};
  Int16Grid points;
};

/// Measures the runtime's projection with an inverse grid, on about max_pixels
/// pixels; nullopt if the format cannot represent the grid.
using InverseGridEvaluator = std::function<std::optional<ProjectionError>(
    const InverseGrid&, double max_pixels)>;

struct EvaluatedInverseGrid {
  InverseGrid grid;
  ProjectionError error;
  bool is_close = false;  ///< one Newton step suffices for every pixel
};

/// Fits the inverse of a surface, which maps chart positions to pixels: the
/// least-squares spline of samples of the whole area except where it folds.
/// Uses the fewest cells for which the runtime finds all valid pixels; more
/// cells, up to 24, if projection then needs only one Newton step, or finds
/// more of the other pixels. If some valid pixels are not found, uses only
/// samples near them, or the grid that misses the fewest. valid_region: NULL if
/// all pixels are valid. nullopt if no grid finds any valid pixel.
std::optional<EvaluatedInverseGrid> FitInverseGrid(
    const BSplineSurface& surface, const ValidityMask* valid_region,
    const InverseGridEvaluator& measure);

/// Measures the runtime's projection with the inverse grid of one of several
/// surfaces; otherwise like InverseGridEvaluator.
using SingleInverseGridEvaluator = std::function<std::optional<ProjectionError>(
    size_t surface, const InverseGrid&, double max_pixels)>;

/// Fits the inverses of the surfaces of one camera at several operating points,
/// which differ only in control points: over a common rectangle and cone, with
/// the fewest cells, up to 24, for which the runtime finds all valid pixels of
/// each surface in one step; otherwise with the number of cells that misses the
/// fewest pixels. nullopt if none can be stored in 16 bits.
std::optional<std::vector<EvaluatedInverseGrid>> FitInverseGridsJointly(
    const std::vector<const BSplineSurface*>& surfaces,
    const ValidityMask* valid_region,
    const SingleInverseGridEvaluator& measure);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_INVERSE_GRID_H
