#ifndef RAYGRID_CAMERA_PAIRED_JET_H
#define RAYGRID_CAMERA_PAIRED_JET_H

#include <ceres/jet.h>

namespace raygrid {

/// A number with its derivatives by kCount variables. Their count is rounded up
/// to an even one, which processors compute in pairs; the last one is then 0.
template <int kCount>
using PairedJet = ceres::Jet<double, kCount + kCount % 2>;

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PAIRED_JET_H
