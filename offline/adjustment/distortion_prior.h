#ifndef RAYGRID_ADJUSTMENT_DISTORTION_PRIOR_H
#define RAYGRID_ADJUSTMENT_DISTORTION_PRIOR_H

#include "adjustment/gaussian_prior.h"
#include "camera/area.h"
#include "camera/parametric_model.h"

namespace raygrid {

/// Distortion coefficients around zero, each in the pixels that it moves the
/// corner of an area by: high orders that the observations say little about
/// stay small, where they would otherwise fold the image beyond the outermost
/// features. Focal lengths and centre are free. A radial spline scatters
/// smoothly around where it is, as a group of its own. So do the terms that
/// tilt the lens, whose weight is at least what camera/decentring.h asks for
/// with so many features.
CameraPrior DistortionPrior(const ParametricModel& lens, const Area& area,
                            int num_features);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_DISTORTION_PRIOR_H
