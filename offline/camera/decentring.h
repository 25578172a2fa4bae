#ifndef RAYGRID_CAMERA_DECENTRING_H
#define RAYGRID_CAMERA_DECENTRING_H

#include "camera/parametric_model.h"

namespace raygrid {

/// Regularization of lens tilt: the tangential terms p1, p2 and the thin-prism
/// terms sx1, sy1, with the principal point, compensate nearly all of a
/// rotation of the camera. For a 62 degree pinhole rotated by 5 degrees, 0.27
/// px (RMS) remain, less than the local distortion of many lenses; least
/// squares alone would tilt the lens by tens of degrees to fit a local bump. So
/// a term that moves the farthest corner by one pixel has the same cost as this
/// fraction of the RMS fit error, averaged over the area. A lens that is really
/// tilted, with a tiny fit error, is fitted without bias.
constexpr double kMaxDecentringFraction = 0.03;

/// Returns the displacement of the area's farthest corner per unit of each tilt
/// or tangential parameter, in pixels; zero for all other parameters.
Eigen::VectorXd ComputeDecentringDisplacement(const ParametricModel& lens,
                                              const Area& area);

/// Returns the displacement of the area's farthest corner per unit of each
/// radial distortion parameter, in pixels; zero for all other parameters,
/// including spline control points.
Eigen::VectorXd ComputeRadialDisplacement(const ParametricModel& lens,
                                          const Area& area);

/// Returns the farthest corner's distance from (cx, cy) in focal lengths.
double ComputeCornerRadius(const ParametricModel& lens, const Area& area);

/// Returns the index of fx; fy, cx, cy follow.
int FirstCommonParameter(const ParametricModel& lens);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_DECENTRING_H
