#ifndef RAYGRID_PACKING_PROJECTION_START_H
#define RAYGRID_PACKING_PROJECTION_START_H

#include <cstdint>
#include <vector>

#include "camera/bspline_surface.h"
#include "rg_blob.h"

namespace raygrid {

/// A projection start section and the array that it points to.
struct ProjectionStart {
  rg_start_section section = {};
  std::vector<int16_t> vertices;
};

/// For every chart position that the surface reaches, about where it does:
/// the nearest of a few thousand samples, and its tangent.
ProjectionStart MakeProjectionStart(const BSplineSurface& surface);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PROJECTION_START_H
