#ifndef RAYGRID_ADJUSTMENT_SMOOTHNESS_PRIOR_H
#define RAYGRID_ADJUSTMENT_SMOOTHNESS_PRIOR_H

#include <vector>

#include "adjustment/gaussian_prior.h"
#include "camera/bspline_surface.h"
#include "camera/central_generic.h"

namespace raygrid {

/// Makes the smoothness prior of a grid: K is the precision of a Matern field
/// (matern_field.h) of the displacement in pixels from base. It regularizes
/// control points that few observations determine towards their neighbours and
/// the base model. The orientation term also fixes the gauge, the camera's
/// orientation: the mean rotation of the directions of observed_px relative to
/// base, or of pixels all over the area if observed_px is empty. With a mean
/// over the whole area, a rotation of the camera could be compensated by the
/// opposite rotation of extrapolated corners; the cost would hardly change, and
/// convergence would be slow.
///
/// The parameters of the base model are unpenalized, except for the precision
/// from its own fit: the field represents only deviations that the model
/// cannot, and extrapolates like the model. Without one, focal lengths and
/// principal point are unpenalized, and radial distortion of orders 3, 5 and 7
/// nearly so.
///
/// spread is the covariance of a fleet, if base is its population mean:
/// displacement fields in pixels, each with a standard normal coefficient. The
/// smoothness then applies to the remainder, without any rotation.
CameraPrior MakeSmoothnessPrior(const CentralGeneric& base,
                                const std::vector<Eigen::Vector2d>& observed_px,
                                const BaseModel& lens = {},
                                const std::vector<BSplineSurface>& spread = {});

/// Makes the priors of an operating-point model, one group per polynomial term:
/// the first about base, the others about zero, so that changes which the data
/// do not determine stay zero. The camera does not rotate with the operating
/// point: that is not observable, since each observation has its own pose.
CameraPrior MakeOperatingPointPrior(const CentralGeneric& base, int num_terms);

/// Makes the prior of a non-central grid: for the directions as above and, as a
/// second group, three smooth zero-mean fields for the points of the lines, in
/// the pixels by which displacement across a line moves an image at distance_m.
///
/// A common shift of all points is compensated by the poses and thus not
/// observable: it is chosen by this prior. Motion of the points along their
/// lines, o(x) -> o(x) + f(x) d(x), is not observable either. The prior
/// penalizes it strongly, so that each point stays in the plane perpendicular
/// to base's direction.
CameraPrior MakeNonCentralPrior(const CentralGeneric& base,
                                const std::vector<Eigen::Vector2d>& observed_px,
                                double distance_m, const BaseModel& lens = {});

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_SMOOTHNESS_PRIOR_H
