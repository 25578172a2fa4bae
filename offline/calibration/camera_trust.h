#ifndef RAYGRID_CALIBRATION_CAMERA_TRUST_H
#define RAYGRID_CALIBRATION_CAMERA_TRUST_H

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/camera_uncertainty.h"

namespace raygrid {

/// How well an adjusted camera is known (adjustment/covariance.h), and where it
/// can be trusted: where it is known twice as well as one feature is measured,
/// or to 0.025 px, what the prior leaves open included, and features were seen
/// near. Standard deviations are those of noise where it can be trusted, of all
/// elsewhere, and twice that where no features were seen near. Nothing if the
/// equations are singular or the adjustment ended before it knew the noise.
std::optional<CameraUncertainty> UncertaintyOf(const Adjusted& adjusted,
                                               int camera, int num_threads);

/// How well a camera is known as each of several others that have its
/// parameters: those of a stack. Deviations are those of noise and of what
/// smoothing takes away. None if the equations are singular.
std::vector<DeviationLattice> DeviationsOf(
    const Adjusted& adjusted, int camera,
    const std::vector<const CameraModel*>& as, int num_threads);

/// Cells that are not lit as a whole are not trusted.
void DistrustBeyond(const ImageCircle& circle, TrustMask* mask);

/// How far the features of some images would be off, were the camera calibrated
/// without all of these: for each image the median over its features of the
/// standard deviation of a held-out residual, both coordinates together, in
/// pixels, by the equations of the adjustment. Nothing where these take too
/// long to solve.
std::map<std::string, double> DeviationsWithout(
    const Adjusted& adjusted, int camera, const std::set<std::string>& images,
    int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_TRUST_H
