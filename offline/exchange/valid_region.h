#ifndef RAYGRID_EXCHANGE_VALID_REGION_H
#define RAYGRID_EXCHANGE_VALID_REGION_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_uncertainty.h"

namespace raygrid {

/// mrcal's valid_intrinsics_region: a closed contour (the last point equals the
/// first) around the valid region. Empty if there is no valid pixel.
using ValidRegion = std::vector<Eigen::Vector2d>;

/// Outlines the largest connected component of the valid cells, along their
/// edges. Cells that touch only at a corner are not connected. Holes are
/// ignored.
ValidRegion ComputeValidRegion(const ValidityMask& mask, const ImageSize& size);

/// Returns the mask of the cells whose centre (clipped to the image) is in the
/// region.
ValidityMask MakeValidityMask(const ValidRegion& region, const ImageSize& size);

/// Number of valid cells outside a region, and of invalid cells inside it.
struct RegionLoss {
  int num_left_out = 0, num_held = 0;
};
RegionLoss ComputeRegionLoss(const ValidityMask& mask, const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_VALID_REGION_H
