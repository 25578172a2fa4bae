#ifndef RAYGRID_CAMERA_DECENTRING_H
#define RAYGRID_CAMERA_DECENTRING_H

#include "camera/parametric_model.h"

namespace raygrid {

/// A tilted lens: the tangential terms p1, p2 and the thin-prism terms sx1,
/// sy1, together with the centre, undo nearly all of a rotation of the camera.
/// A 62 degree pinhole turned by 5 degrees is off by 0.27 px (RMS) after them,
/// which is less than local distortion leaves of many lenses; least squares
/// alone would turn the lens by tens of degrees to follow a bump. So, on the
/// average over all places, a term that moves the farthest corner by one pixel
/// counts as much as this part of the error that the lens leaves. A lens that
/// is tilted indeed, and leaves next to nothing, is found as it is.
constexpr double kDecentringPart = 0.03;

/// How far a unit of each parameter that tilts the lens moves the farthest
/// corner of an area, in pixels; zero for all other parameters.
Eigen::VectorXd DecentringPixels(const ParametricModel& lens, const Area& area);

/// How far a unit of each parameter that bends the lens moves the farthest
/// corner of an area, in pixels; zero for all other parameters, and for those
/// of a spline.
Eigen::VectorXd RadialPixels(const ParametricModel& lens, const Area& area);

/// The farthest corner's distance from the lens's centre, in focal lengths.
double CornerRadius(const ParametricModel& lens, const Area& area);

/// The index of fx among the parameters, which cx, cy are 2 and 3 behind.
int FirstCommonParameter(const ParametricModel& lens);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_DECENTRING_H
