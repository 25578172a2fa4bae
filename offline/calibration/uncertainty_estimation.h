#ifndef RAYGRID_CALIBRATION_UNCERTAINTY_ESTIMATION_H
#define RAYGRID_CALIBRATION_UNCERTAINTY_ESTIMATION_H

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/camera_uncertainty.h"
#include "evaluation/uncertainty_summary.h"

namespace raygrid {

/// The limit of the valid region where the user sets none: max(0.25 px, 3 sigma
/// of the feature noise).
double DefaultValidLimitPx(double noise_px);

/// The predicted uncertainty of an adjusted camera, and where it is
/// extrapolated.
struct EstimatedUncertainty {
  CameraUncertainty uncertainty;
  ExtrapolatedRegion extrapolated;
};

/// Estimates the uncertainty of an adjusted camera (adjustment/covariance.h).
/// The valid region is where features are near and the standard deviation, what
/// the prior leaves open included, is below the limit; without one, below
/// DefaultValidLimitPx(). Stated standard deviations are those of noise where
/// the data determines the camera, of all elsewhere, and twice that where it is
/// extrapolated. Nothing if the normal equations are singular or the adjustment
/// ended before it estimated the noise.
std::optional<EstimatedUncertainty> EstimateUncertainty(
    const AdjustmentResult& adjusted, int camera,
    const std::optional<ImageCircle>& image_circle,
    const std::optional<double>& valid_limit_px, int num_threads);

/// How well a camera is known as each of several others that have its
/// parameters: those of a stack. Deviations are those of noise and of what
/// smoothing takes away. None if the equations are singular.
std::vector<UncertaintyLattice> EstimateStandardDeviations(
    const AdjustmentResult& adjusted, int camera,
    const std::vector<const CameraModel*>& as, int num_threads);

/// How far the features of some images would be off, were the camera calibrated
/// without all of these: for each image the median over its features of the
/// standard deviation of a held-out residual, both coordinates together, in
/// pixels, by the equations of the adjustment. Nothing where these take too
/// long to solve.
std::map<std::string, double> PredictHeldOutDeviations(
    const AdjustmentResult& adjusted, int camera,
    const std::set<std::string>& images, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_UNCERTAINTY_ESTIMATION_H
