#ifndef RAYGRID_CAMERA_PAIRED_JET_H
#define RAYGRID_CAMERA_PAIRED_JET_H

#include <ceres/jet.h>

namespace raygrid {

/// A number with derivatives with respect to kCount variables. Their number is
/// rounded up to an even one for SIMD; the last derivative is then 0.
template <int kCount>
using PairedJet = ceres::Jet<double, kCount + kCount % 2>;

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PAIRED_JET_H
