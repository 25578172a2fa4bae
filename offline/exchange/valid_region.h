#ifndef RAYGRID_EXCHANGE_VALID_REGION_H
#define RAYGRID_EXCHANGE_VALID_REGION_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_uncertainty.h"

namespace raygrid {

/// mrcal's valid_intrinsics_region: a closed contour around the pixels that a
/// camera can be trusted at, whose last point is the first one. No point if
/// there is no such pixel.
using ValidRegion = std::vector<Eigen::Vector2d>;

/// The outline of the largest part of the trusted cells, along their edges.
/// Cells that touch at a corner alone are not of one part. Holes are not
/// outlined.
ValidRegion ComputeValidRegion(const ValidityMask& mask, const ImageSize& size);

/// The cells whose middle, of what lies in the image, is in a region.
ValidityMask MakeValidityMask(const ValidRegion& region, const ImageSize& size);

/// Trusted cells that a region leaves out, and others that it holds.
struct RegionLoss {
  int num_left_out = 0, num_held = 0;
};
RegionLoss ComputeRegionLoss(const ValidityMask& mask, const ImageSize& size);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_VALID_REGION_H
