#ifndef RAYGRID_ADJUSTMENT_SMOOTHNESS_PRIOR_H
#define RAYGRID_ADJUSTMENT_SMOOTHNESS_PRIOR_H

#include <vector>

#include "adjustment/gaussian_prior.h"
#include "camera/bspline_surface.h"
#include "camera/central_generic.h"

namespace raygrid {

/// Smoothness of a grid's difference from base: K is the precision of a Matern
/// field (matern_field.h) of the displacement in pixels that separates the two.
/// Keeps nodes that few observations determine near where
/// their neighbours and the parametric lens would have them. Also holds the
/// camera's orientation, the gauge, to base's: the mean rotation of the
/// directions of observed_px, or of pixels all over the area if there are none.
/// Over the whole area, the camera could rotate while extrapolated corners
/// rotate the other way: a valley of the cost in which adjustments creep.
///
/// The parameters of the lens are free, as far as its own fit left them: they
/// make up for what it does not follow, and beyond the outermost features they
/// are no better known than the features allow. Without a lens, focal lengths
/// and centre are free, and radial distortion of orders 3, 5 and 7 nearly so.
///
/// spread tells how lenses differ from base, if that is a fleet's middle: by
/// displacements in pixels, each times a standard normal number. Then the
/// smoothness is about what these and the lens leave, of which no part is to be
/// a turn.
CameraPrior SmoothnessPrior(const CentralGeneric& base,
                            const std::vector<Eigen::Vector2d>& observed_px,
                            const BaseLens& lens = {},
                            const std::vector<BSplineSurface>& spread = {});

/// The smoothness priors of a stack's terms, each as that of a grid and a group
/// of its own: the first around base, those by which the camera changes with
/// the conditions around none. What the data do not tell of a term's change
/// stays none. The camera does not turn with a condition: observations cannot
/// tell, since each has its pose.
CameraPrior StackPrior(const CentralGeneric& base, int num_terms);

/// The smoothness prior of the directions of a grid of lines, and, as a group
/// of its own, of the lines' points around the origin: three smooth fields, in
/// the pixels that their displacement across the line moves a point's image at
/// distance_m.
///
/// Observations do not see a shift of all points together, which the poses
/// undo: the points end where they are smallest and smoothest. Nor do they see
/// points drift along the lines, o(x) -> o(x) + f(x) d(x): the prior holds each
/// control point's point in the plane across base's direction.
CameraPrior NonCentralPrior(const CentralGeneric& base,
                            const std::vector<Eigen::Vector2d>& observed_px,
                            double distance_m, const BaseLens& lens = {});

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_SMOOTHNESS_PRIOR_H
