#ifndef RAYGRID_ADJUSTMENT_DISTORTION_PRIOR_H
#define RAYGRID_ADJUSTMENT_DISTORTION_PRIOR_H

#include "adjustment/gaussian_prior.h"
#include "camera/area.h"
#include "camera/parametric_model.h"

namespace raygrid {

/// Makes the prior of a parametric model: zero-mean for distortion
/// coefficients, each scaled to its displacement (px) in the corner of the
/// area. It regularizes high orders, which could otherwise cause folds outside
/// the area with features. Focal lengths and principal point are unpenalized. A
/// radial spline has a smooth prior about its current values, in a separate
/// group; so do tangential and thin-prism terms, with a precision floor for the
/// number of features (camera/decentring.h).
CameraPrior MakeDistortionPrior(const ParametricModel& lens, const Area& area,
                                int num_features);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_DISTORTION_PRIOR_H
