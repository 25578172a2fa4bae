#ifndef RAYGRID_INITIALIZATION_RADIAL_INITIALIZATION_H
#define RAYGRID_INITIALIZATION_RADIAL_INITIALIZATION_H

#include <optional>

#include "camera/thin_prism_fisheye.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Initializes a central camera from planar boards, for a lens of any field of
/// view that is nearly symmetric about an axis. The calibrated area is the
/// whole image. Returns nullopt if no such lens fits the features.
///
/// A pixel at d = x - c from the distortion centre c has the direction (d,
/// G(|d|)), not normalized, for any lens: G = f is a pinhole, G < 0 is behind
/// the camera. A board's point q = (X, Y, 1) is at (a q, b q, z) in the camera,
/// with rows a = (r11, r12, t1), b = (r21, r22, t2) and z = r31 X + r32 Y + t3.
///
/// 1. d and (a q, b q) are parallel in the image plane, which does not involve
/// G: d_x (b q)
/// - d_y (a q) = 0, linear in (a, b), determined for each view up to scale (a
/// radial homography; Tsai, 1987; Thirthala and Pollefeys, 2012). The sign puts
/// points on the same side of c as their pixels. c minimizes the residuals of
/// all views.
/// 2. The upper left 2 x 2 block of a rotation has 1 as its larger singular
/// value: U diag(1, cos) V^T, a rotation about the axis and a tilt. That
/// determines the scale, and (r31, r32) = s sin V_2^T with a sign s = +-1.
/// 3. With r = |d|, rho = |(a q, b q)| and an even polynomial G, s (r31 X + r32
/// Y) r + t3 r - rho sum_k g_k r^2k = 0, linear in all views' t3 and the g_k.
/// Starting from one view, the signs of the others are chosen by the residual
/// until no sign changes.
/// 4. r = f theta (1 + k1 theta^2 + k2 theta^4) is fitted to theta = atan2(r,
/// G).
std::optional<ThinPrismFisheye> InitializeFromRadialLines(
    const Dataset& dataset, const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_RADIAL_INITIALIZATION_H
